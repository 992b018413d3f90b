#!/usr/bin/env python3
"""Durations of plans with `--improve`, as a table of docs/BENCHES.md.

    tools/bench_improvement.py target/release/surefoot --seeds 1 --scenarios ibeam_hallway stairs

Improves each plan with 1, 4 and 16 times the work of the first, and checks every plan.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

FACTORS = (1, 4, 16)


def run(program, *arguments):
    """The report of `surefoot plan`; None without a plan."""
    command = [program, "plan", *arguments, "--quiet", "--json", "-"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else None


def is_accepted(program, plan):
    """Whether the controller's checks accept an exported plan."""
    command = [program, "check", plan]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def row(program, scenario, seed, factors, folder):
    """One line of the table."""
    name = os.path.basename(scenario).removesuffix(".toml")
    first = run(program, scenario, "--seed", str(seed))
    if first is None:
        return f"| {name} | {seed} | no plan |"
    cells = [name, str(seed), str(first["work"]), f"{first['walk']['seconds']:.2f}"]
    for factor in factors:
        plan = os.path.join(folder, "plan.json")
        work = str(factor * first["work"])
        report = run(program, scenario, "--seed", str(seed), "--improve", work, "--export", plan)
        improved = report["improved"]
        verdict = "" if is_accepted(program, plan) else " refused"
        cells.append(f"{improved['seconds']:.2f} ({report['steps']} steps){verdict}")
    return "| " + " | ".join(cells) + " |"


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--factors", nargs="+", type=int, default=list(FACTORS))
    parser.add_argument("--scenarios", nargs="+", required=True)
    arguments = parser.parse_args()
    factors = arguments.factors
    print("| scenario | seed | work | first, s | " + " | ".join(f"{f}x" for f in factors) + " |")
    print("| --- |" + " --- |" * (3 + len(factors)))
    with tempfile.TemporaryDirectory() as folder:
        for scenario in arguments.scenarios:
            for seed in arguments.seeds:
                print(row(arguments.program, scenario, seed, factors, folder), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
