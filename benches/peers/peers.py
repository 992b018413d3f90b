"""Compares Surefoot with Pinocchio, Coal and OMPL in one run.

Robot, scene and configurations are the same. Prints times, ratios and versions. All times are the
fastest of some batches. A ratio above 1 is the factor by which Surefoot is faster. A note in each
line names the work that a peer leaves out.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np
import pinocchio as pin

import constrained
import sampling
from robot import Robot

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENARIOS = ("ibeam_gap", "stepping_stones", "cinder_blocks")
# Surefoot lifts stance feet by this height before a collision test; the peers receive
# configurations raised by it, m.
LIFT = 0.0015


def cargo(*arguments):
    """The JSON output of one of Surefoot's measurements."""
    result = subprocess.run(["cargo", *arguments], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if result.returncode not in (0, 3):
        raise SystemExit(2)
    return json.loads(result.stdout[result.stdout.index("{") :])


def best_seconds(call, batches=21):
    """The shortest time of a call, s: the one least affected by other load."""
    call()
    times = []
    for _ in range(batches):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


class Report:
    def __init__(self):
        self.rows, self.disagreements = [], []

    def add(self, what, ours, peer, theirs, note=""):
        ratio = theirs / ours if ours and theirs else None
        self.rows.append({"what": what, "surefoot_seconds": ours, "peer": peer, "peer_seconds": theirs, "ratio": ratio, "note": note})

    def print(self):
        show = lambda seconds: "-" if seconds is None else f"{seconds * 1e6:.2f} us"
        print(f"{'what':<46}{'surefoot':>14}  {'peer':<34}{'time':>16}{'ratio':>10}  note")
        for row in self.rows:
            ratio = "-" if row["ratio"] is None else f"{row['ratio']:.1f} x"
            ours, theirs = show(row["surefoot_seconds"]), show(row["peer_seconds"])
            print(f"{row['what']:<46}{ours:>14}  {row['peer']:<34}{theirs:>16}{ratio:>10}  {row['note']}")


def kinematics(report, ours, robot, configuration):
    """Forward kinematics and centre of mass, called from Python a thousand times."""
    q, calls = robot.q(configuration), 1000
    model, data = robot.model, robot.data

    def each(function):
        return best_seconds(lambda: [function() for _ in range(calls)]) / calls

    empty = each(lambda: None)
    forward = each(lambda: pin.forwardKinematics(model, data, q)) - empty
    both = each(lambda: pin.centerOfMass(model, data, q, False)) - empty
    note = "each call crosses from Python to C++"
    both_ours = ours["kinematic state: forward kinematics, centre of mass"]["best_ns"] * 1e-9
    report.add("forward kinematics and centre of mass", both_ours, "Pinocchio centerOfMass(q)", both, note)
    report.add("the same", both_ours, "Pinocchio forwardKinematics alone", forward, note)


def checks(report, problem, name, threads):
    """The configurations of a plan, checked by both."""
    with tempfile.TemporaryDirectory() as folder:
        path, scenario = os.path.join(folder, "plan.json"), f"configs/scenarios/{name}.toml"
        subprocess.run(
            ["cargo", "run", "--release", "--quiet", "--", "plan", scenario, "--seed", "1", "--quiet", "--export", path],
            cwd=ROOT, stdout=subprocess.DEVNULL, check=True,
        )
        with open(path) as file:
            plan = json.load(file)
    limit = cargo("run", "--release", "--quiet", "--", "bench", "limit", "--scenario", name, "--trials", "1", "--threads", threads, "--json")
    row = limit["rows"][0]
    ours = row["check_mean_seconds"] / row["check_mean_configurations"]
    robot = Robot(problem, plan["scene"]["shapes"])
    configurations = [{"root_xyz": w["root_xyz"], "root_quat_xyzw": w["root_quat_xyzw"], "q": w["q"]} for w in plan["waypoints"]]
    batch = np.array([robot.q(configuration, LIFT) for configuration in configurations]).T
    pool = pin.GeometryPool(robot.model, robot.geometry, 1)
    results = pin.computeCollisionsInParallel(1, pool, batch, True)
    if np.any(results):
        report.disagreements.append(f"{name}: Coal finds {int(np.sum(results))} of {len(results)} waypoints in collision")
    note = "peer: no torque, no support, no clearance"
    what, count = f"{name}: one configuration of {len(configurations)}", len(configurations)
    batched = best_seconds(lambda: pin.computeCollisionsInParallel(1, pool, batch, True), 7) / count
    report.add(what, ours, "Pinocchio + Coal, C++ batch", batched, note)
    trees = pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(robot.model, robot.geometry, 1)
    broad = best_seconds(lambda: pin.computeCollisionsInParallel(1, trees, batch, True), 7) / count
    report.add(what, ours, "the same with broad phase", broad, note)


def stances(report, ours, problem, flat_scene, seconds):
    """Random whole-robot stances that hold."""
    rate, share = sampling.per_second(sampling.StanceSampler(Robot(problem, flat_scene), problem), seconds)
    kernel = ours["flat_walk: transition sample, uniform"]
    ours_rate = kernel["per_second"] * kernel["median_ns"] / kernel["best_ns"]
    note = f"{ours_rate:.0f}/s against {rate:.0f}/s ({100 * share:.0f} % hold); peer's loop is Python, without torque"
    report.add("one stance that holds", 1.0 / ours_rate, "Pinocchio IK + Coal", 1.0 / rate if rate else None, note)


def single_mode(report, ours, problem, flat_scene, trials, seconds_max):
    """A weight shift in double support."""
    if problem["shift"] is None:
        return
    robot = Robot(problem, flat_scene)
    kernel = ours["flat_walk: single-mode plan, weight shift"]
    for space in ("ProjectedStateSpace", "AtlasStateSpace"):
        try:
            times = constrained.times(robot, problem["shift"], space, trials, seconds_max)
        except RuntimeError as error:
            report.add("weight shift in double support", kernel["best_ns"] * 1e-9, f"OMPL {space}", None, f"does not run: {error}")
            continue
        found = sorted(time for time in times if time is not None)
        best = found[0] if found else None
        note = f"{len(found)}/{len(times)} solved; validity and constraint are Python calls"
        report.add("weight shift in double support", kernel["best_ns"] * 1e-9, f"OMPL RRTConnect, {space}", best, note)


def versions():
    names = ("pin", "coal", "ompl", "numpy")
    text = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout.strip()
    return {"surefoot": text, "python": platform.python_version(), **{name: importlib.metadata.version(name) for name in names}}


def processor():
    with open("/proc/cpuinfo") as file:
        return next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "unknown")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", help="a robot.toml in place of the reference robot, on the flat floor only")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long the peer samples stances")
    parser.add_argument("--trials", type=int, default=5, help="searches of each of OMPL's spaces")
    parser.add_argument("--seconds-max", type=float, default=20.0, help="the time limit of one such search")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    chosen = ["--robot", os.path.abspath(options.robot)] if options.robot else []
    measured = cargo("bench", "--quiet", "--bench", "kernels", "--", "--json", *chosen)
    ours, problem = {kernel["name"]: kernel for kernel in measured["kernels"]}, measured["problem"]
    floor = [{"name": "floor", "pose": {"xyz": [5.0, 0.0, -0.25], "quat_xyzw": [0, 0, 0, 1]}, "shape": {"type": "box", "half_extents": [5.0, 1.0, 0.25]}}]
    report = Report()
    kinematics(report, ours, Robot(problem), problem["standing"])
    if not options.robot:
        for name in SCENARIOS:
            if os.path.exists(os.path.join(ROOT, f"configs/scenarios/{name}.toml")):
                checks(report, problem, name, "1")
    stances(report, ours, problem, floor, options.seconds)
    single_mode(report, ours, problem, floor, options.trials, options.seconds_max)
    if options.json:
        head = {"schema": "surefoot-bench-peers/1", "processor": processor(), "versions": versions(), "robot": problem["robot"]}
        print(json.dumps({**head, "rows": report.rows, "disagreements": report.disagreements}, indent=1))
    else:
        print(f"{processor()}; robot {problem['robot']}; " + ", ".join(f"{name} {version}" for name, version in versions().items()))
        report.print()
        for disagreement in report.disagreements:
            print(f"DISAGREEMENT {disagreement}")
    sys.exit(1 if report.disagreements else 0)


if __name__ == "__main__":
    main()
