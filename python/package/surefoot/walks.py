"""One walk of a batch: planned, checked, and written as one row."""

from __future__ import annotations

import functools
import hashlib
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.checker import Checker
from surefoot.errors import Error, NoPlan
from surefoot.plans import Plan
from surefoot.robot import Robot
from surefoot.scenario import Scenario

MARGINS = ("limits", "contact", "balance", "collision", "self_collision", "torque")
"""The checks whose worst margin a row holds."""


@dataclass(frozen=True, order=True)
class Task:
    """A walk to plan: a scenario, a robot in place of the scenario's, and a seed."""

    scenario: str
    """A scenario file, or the name of one that the package carries."""
    robot: str
    """A robot file or a name; empty for the scenario's own robot."""
    seed: int
    """The seed of all random streams."""


@dataclass(frozen=True)
class Options:
    """What is the same for all walks of a batch."""

    threads: int = 1
    """Threads of each search."""
    work_max: int | None = None
    """Limit of the work of each search, in place of the scenario's."""
    plans: str = ""
    """Folder for the plan files; empty to keep none."""


@functools.cache
def _scenario(scenario: str) -> Scenario:
    return Scenario(scenario)


@functools.cache
def _robot(robot: str) -> Robot:
    return Robot(robot)


def walk(task: Task, options: Options) -> tuple[dict[str, Any], dict[str, Any]]:
    """Plans and checks a walk. Returns what depends on the inputs alone, and what does not: the
    time that it took and the process."""
    begin = time.perf_counter()
    row: dict[str, Any] = {"scenario": task.scenario, "robot": task.robot, "seed": task.seed}
    try:
        row |= _planned_and_checked(task, options)
    except NoPlan as error:
        row |= {"outcome": error.outcome, "message": str(error), "work": error.stats.get("work")}
    except Error as error:
        row |= {"outcome": "error", "message": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - begin
    key = {"scenario": task.scenario, "robot": task.robot, "seed": task.seed}
    return row, {**key, "seconds": seconds, "process": os.getpid()}


def _planned_and_checked(task: Task, options: Options) -> dict[str, Any]:
    scenario = _scenario(task.scenario)
    robot = _robot(task.robot) if task.robot else scenario.robot
    bounds = {} if options.work_max is None else {"planner": {"work_max": options.work_max}}
    plan = scenario.plan(
        robot=robot, seed=task.seed, threads=options.threads, parameters=bounds
    )
    report = Checker(robot).check(plan, scenario)
    row = _measured(plan)
    row |= {f"margin_{name}": report.margins.get(name) for name in MARGINS}
    row["outcome"] = "accepted" if report.valid else "refused"
    row["message"] = "; ".join(report.violations())
    if options.plans:
        plan.save(Path(options.plans) / _plan_name(task, robot))
    return row


def _plan_name(task: Task, robot: Robot) -> str:
    """The name of a task's plan file, with a digest of the paths if scenario or robot is a file:
    others may have the same name."""
    parts = [Path(task.scenario).stem, robot.name, str(task.seed)]
    if task.scenario.endswith(".toml") or task.robot.endswith(".toml"):
        paths = f"{task.scenario}\0{task.robot}"
        parts.append(hashlib.sha256(paths.encode()).hexdigest()[:8])
    return "-".join(parts) + ".json"


def _measured(plan: Plan) -> dict[str, Any]:
    path = plan.waypoints.root_position
    return {
        "digest": plan.digest,
        "steps": len(plan.footholds) - 2,
        "waypoints": len(plan.waypoints),
        "duration": plan.duration,
        "root_path": float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()),
        "work": plan.stats["work"],
        "sequences": plan.stats["sequences"],
    }
