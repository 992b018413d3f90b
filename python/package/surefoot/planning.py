"""Planning."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from surefoot import _native
from surefoot.errors import ParameterError
from surefoot.parameters import ParameterTables, parameters_of
from surefoot.plans import Plan
from surefoot.robot import Robot
from surefoot.stance import Goal, Stance, goal_of, stance_of
from surefoot.world import World

SEED_MAX = 2**64 - 1
"""The largest seed."""


@dataclass(frozen=True)
class _Search:
    start: tuple[float, float, float, float, float | None]
    goal: tuple[float, float, float, float, float | None, float, float]
    seed: int
    threads: int
    improve: int


def plan(
    robot: Robot | str | os.PathLike[str],
    world: World | str | os.PathLike[str],
    start: Stance | Sequence[float],
    goal: Goal | Stance | Sequence[float],
    *,
    seed: int = 1,
    threads: int | None = None,
    work_max: int | None = None,
    improve: int = 0,
    parameters: ParameterTables | _native.Parameters | None = None,
) -> Plan:
    """Finds a whole-body walk in this process. Other Python threads run meanwhile.

    ``robot`` and ``world`` are objects, paths, or names of those that the package carries.
    ``start`` and ``goal`` are x, y, z (m) and maybe yaw (rad), or a :class:`Stance` and a
    :class:`Goal`. The same inputs and the same ``seed`` give the same plan, whatever the number of
    ``threads`` (by default one for each core). ``work_max`` bounds the search, in work units of
    about ten microseconds. ``improve`` work units after the first plan make other walks from it, and
    the one that takes the least time is the plan; ``Plan.stats["improved"]`` says what they came
    to. ``parameters`` are tables ``planner``, ``checker`` and ``execution``
    with the entries of a scenario file.

    Raises :class:`NoPlan` if the search ends without a plan, :class:`ParameterError`,
    :class:`RobotError` or :class:`InputError` if it cannot begin.
    """
    if isinstance(parameters, _native.Parameters):
        native = parameters
    else:
        native = parameters_of(parameters)
    if work_max is not None:
        native = parameters_of({"planner": {"work_max": work_max}}, native)
    if not 0 <= seed <= SEED_MAX:
        raise ParameterError(f"seed is {seed}; it is between 0 and {SEED_MAX}", parameter="seed")
    if threads is not None and threads < 1:
        raise ParameterError(f"threads is {threads}; at least 1", parameter="threads")
    if not 0 <= improve <= SEED_MAX:
        raise ParameterError(
            f"improve is {improve}; it is between 0 and {SEED_MAX}", parameter="improve"
        )
    search = _Search(
        stance_of(start)._numbers(),
        goal_of(goal)._all_numbers(),
        seed,
        threads or len(os.sched_getaffinity(0)),
        improve,
    )
    robot = robot if isinstance(robot, Robot) else Robot(robot)
    world = world if isinstance(world, World) else World(world)
    found, stats, route = _native.plan(robot._native, world._native, native, search)
    return Plan(found, stats, route, found.digest)
