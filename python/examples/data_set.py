"""Makes a data set of walks with its statistics page.

    pip install "surefoot[batch]"
    python data_set.py                    # 12 walks
    python data_set.py --walks 10000      # a data set to learn from

It holds walks.parquet (a row for each walk), times.parquet, plans/ (the motions) and
statistics.html.
"""

from __future__ import annotations

import argparse

from surefoot import batch
from surefoot.statistics import write_page

SCENARIOS = ("flat_walk", "stepping_stones", "ibeam_hallway", "stairs")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--walks", type=int, default=12)
    parser.add_argument("--out", default="data_set")
    parser.add_argument("--workers", type=int, help="cores of this machine (all)")
    parser.add_argument("--address", help="of a Ray cluster")
    options = parser.parse_args()
    seeds = range(1, 1 + -(-options.walks // len(SCENARIOS)))
    summary = batch.run(
        SCENARIOS,
        seeds,
        out=options.out,
        workers=options.workers,
        address=options.address,
        plans=True,
    )
    print(f"{summary.walks} walks: {summary.outcomes}")
    print(f"see {write_page(options.out)}")


if __name__ == "__main__":
    main()
