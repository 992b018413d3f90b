#!/usr/bin/env python3
"""Plans smooth walks, replays them in MuJoCo (tools/replay_mujoco.py), and prints a table.

usage: bench_physics.py SCENARIO.toml ... [--seeds N] [--disturbed N] [--late N]
                        [--surefoot PROGRAM]

Each scenario is planned with the seeds 1 to N, and each plan is replayed once as it is, and
--disturbed times with other masses (5 %), friction (0.8 to 1 times) and delays (up to 4 ms). With
--late, so many walks whose chunks come late at random (surefoot bench late) are replayed as they
were executed: with their stops. A replay is good where the robot stands at the end, its root never
more than 5 cm from the plan, and each foot lands within 5 mm of its place relative to the other
foot.

exit: 0 all are good, 1 one is not. Needs `pip install mujoco`.
"""

import argparse
import multiprocessing
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import replay_mujoco  # noqa: E402 (the tool beside this one)

# Distances beyond which a replay is not good, m.
ROOT_MAX, LANDING_MAX = 0.05, 0.005


def name_of(scenario):
    """The folder and the name of a scenario: robots of one's own keep theirs in a folder each."""
    return f"{scenario.parent.name}/{scenario.stem}"


def plan(surefoot, scenario, seed, folder):
    """The exported plan; nothing if there is none."""
    path = folder / f"{scenario.parent.name}-{scenario.stem}-{seed}.json"
    command = [surefoot, "plan", scenario, "--motion", "smooth", "--seed", str(seed), "--quiet"]
    done = subprocess.run([*command, "--export", path], capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{name_of(scenario)}, seed {seed}: {done.stdout}{done.stderr}", file=sys.stderr)
        return None
    return path


def walks_with_late_chunks(surefoot, scenario, count, folder):
    """The exported walks of a scenario with late chunks; fewer if one is not within limits."""
    walked = folder / f"{scenario.parent.name}-{scenario.stem}-late"
    walked.mkdir()
    command = [surefoot, "bench", "late", scenario, "--walks", str(count), "--out", walked]
    done = subprocess.run(command, capture_output=True, text=True)
    print(f"{name_of(scenario)}: {done.stdout}{done.stderr}".rstrip(), file=sys.stderr)
    return sorted(walked.iterdir())


def replay(task):
    path, disturbance = task
    try:
        return replay_mujoco.replay(path, disturbance)
    except replay_mujoco.Unusable as error:
        print(f"{path.name}: {error}", file=sys.stderr)
        return None


def is_good(outcome):
    landing = max(outcome.landings, default=0.0)
    return outcome.stands and outcome.root <= ROOT_MAX and landing <= LANDING_MAX


def row(name, kind, outcomes):
    """A row of the table, and whether all outcomes are good."""
    found = [outcome for outcome in outcomes if outcome is not None]
    good = sum(map(is_good, found))
    worst = lambda values: f"{1e3 * max(values, default=0.0):.1f}"
    falls = ", ".join(f"{o.seconds:.1f} s" for o in found if not o.stands) or "-"
    roots = worst(o.root for o in found if o.stands)
    landings = worst(error for o in found if o.stands for error in o.landings)
    print(f"| {name} | {kind} | {len(outcomes)} | {sum(o.stands for o in found)} | {good} | "
          f"{roots} | {landings} | {falls} |", flush=True)
    return good == len(outcomes)


def main():
    parser = argparse.ArgumentParser(description="Replays smooth walks in MuJoCo, in a table.")
    parser.add_argument("scenarios", nargs="+", type=Path, metavar="SCENARIO.toml")
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--disturbed", type=int, default=1, metavar="N")
    parser.add_argument("--late", type=int, default=0, metavar="N")
    parser.add_argument("--surefoot", default="target/release/surefoot", metavar="PROGRAM")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    arguments = parser.parse_args()
    print("| walk | robot | replays | stand | good | root, mm | landing, mm | falls after |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |", flush=True)
    all_good = True
    with tempfile.TemporaryDirectory() as folder, \
            multiprocessing.Pool(arguments.processes) as pool:
        for scenario in arguments.scenarios:
            seeds = range(1, arguments.seeds + 1)
            plans = [plan(arguments.surefoot, scenario, seed, Path(folder)) for seed in seeds]
            plans = [path for path in plans if path is not None]
            all_good &= len(plans) == arguments.seeds
            kinds = {"as planned": [(path, None) for path in plans],
                     "disturbed": [(path, 1 + draw) for path in plans
                                   for draw in range(arguments.disturbed)]}
            if arguments.late > 0:
                late = walks_with_late_chunks(
                    arguments.surefoot, scenario, arguments.late, Path(folder))
                kinds["with late chunks"] = [(path, None) for path in late]
                all_good &= len(late) == arguments.late
            for kind, tasks in kinds.items():
                if tasks:
                    all_good &= row(name_of(scenario), kind, pool.map(replay, tasks, 1))
    sys.exit(0 if all_good else 1)


if __name__ == "__main__":
    main()
