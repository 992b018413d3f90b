#!/usr/bin/env python3
"""Plans 1,000 short walks on two Ray workers, kills one of them in the middle, and plans all walks
again one by one: every walk has one row, and the rows are the same.

Needs the wheel with `[batch]` (tools/check_python.sh builds it). Exit code 1 if anything differs.
"""

import argparse
import collections
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time

import pyarrow.parquet as parquet

import surefoot
from surefoot import batch
from surefoot.walks import Options, Task, walk

GOALS = 10
"""Scenarios: walks of 0.3 m to 1.2 m on a level floor."""


def write_scenarios(folder):
    """The scenario files."""
    shipped = surefoot.Scenario("flat_walk")
    paths = []
    for number in range(GOALS):
        path = folder / f"goal_{number}.toml"
        path.write_text(
            f'robot = "{shipped.robot_path}"\nworld = "{shipped.world_path}"\n'
            f"start = {{ xyz = [0.5, 0.0, 0.0] }}\n"
            f"goal = {{ xyz = [{0.8 + 0.1 * number:.1f}, 0.0, 0.0] }}\n"
        )
        paths.append(str(path))
    return paths


def kill_in_the_middle(out, stop, killed, rows_min):
    """Kills one of the batch's own workers while it plans, once so many rows are kept."""
    while not stop.is_set():
        rows = [
            row
            for part in sorted((out / "parts").glob("*.times.parquet"))
            for row in parquet.read_table(part).to_pylist()
        ]
        for process in {row["process"] for row in rows} if len(rows) >= rows_min else ():
            try:
                is_busy = (
                    pathlib.Path(f"/proc/{process}/cmdline").read_bytes().startswith(b"ray::walk")
                )
                if is_busy:
                    os.kill(process, signal.SIGKILL)
                    killed.append((process, len(rows)))
                    return
            except OSError:
                continue
        time.sleep(0.005)


def run_batch(scenarios, seeds, out):
    """The batch with a worker killed; returns its summary and who was killed when."""
    stop, killed = threading.Event(), []
    rows_min = len(scenarios) * len(seeds) // 2 - batch.PART_ROWS
    killer = threading.Thread(target=kill_in_the_middle, args=(out, stop, killed, rows_min))
    killer.start()
    try:
        summary = batch.run(scenarios, seeds, out=out, workers=2)
    finally:
        stop.set()
        killer.join()
    return summary, killed


def differences(rows, scenarios, seeds):
    """Missing, double and differing rows of a batch, as lines of text."""
    tasks = sorted(Task(scenario, "", seed) for scenario in scenarios for seed in seeds)
    found = collections.Counter(Task(row["scenario"], row["robot"], row["seed"]) for row in rows)
    for task in tasks:
        if found[task] != 1:
            yield f"{task}: {found[task]} rows"
    by_task = {Task(row["scenario"], row["robot"], row["seed"]): row for row in rows}
    for task in tasks:
        alone, _ = walk(task, Options())
        for key, value in alone.items():
            if by_task[task][key] != value:
                yield f"{task}: {key} is {by_task[task][key]}, alone {value}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100, help="seeds of each of ten goals")
    options = parser.parse_args()
    seeds = range(1, options.seeds + 1)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "walks"
        scenarios = write_scenarios(pathlib.Path(folder))
        begin = time.monotonic()
        summary, killed = run_batch(scenarios, seeds, out)
        seconds = time.monotonic() - begin
        rows = parquet.read_table(out / "walks.parquet").to_pylist()
        times = parquet.read_table(out / "times.parquet").to_pylist()
        again = sum(row["attempts"] > 1 for row in times)
        wrong = list(differences(rows, scenarios, seeds))
    print(f"{summary.walks} walks in {seconds:.0f} s: {summary.outcomes}, {len(summary.lost)} lost")
    print(f"killed (process, rows so far): {killed}; {again} walks were given out again")
    print(f"{len({row['digest'] for row in rows})} digests; {len(wrong)} differ from one by one")
    if wrong or not killed or not again or summary.lost:
        sys.exit("\n".join(wrong) or "no worker was killed while it planned, or walks were lost")


if __name__ == "__main__":
    main()
