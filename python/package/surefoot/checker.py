"""The controller's checks, whose code shares no algorithm with the planner."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surefoot import _native
from surefoot.errors import ParameterError, Refused
from surefoot.parameters import ParameterTables, parameters_of
from surefoot.plans import Plan
from surefoot.robot import Robot

if TYPE_CHECKING:
    from surefoot.scenario import Scenario


@dataclass(frozen=True)
class CheckResult:
    """The result of one check of a plan."""

    check: str
    """Its name: ``limits``, ``contact``, ``balance``, ..."""
    margin: float | None
    """The worst margin among the phases that pass; None for a check that measures none."""
    phase: int | None
    """The phase of that margin."""
    violation: str | None
    """The first violation, in words; None if the check holds."""
    violated_phase: int | None = None
    """The phase of the violation."""
    violated_waypoint: int | None = None
    """The waypoint of the violation, counted from the plan's beginning."""


@dataclass(frozen=True)
class End:
    """How far a plan begins or ends from where it must."""

    error: float | None
    """The distance, m; a rotation error of 1 rad counts as 0.5 m."""
    limit: float
    """The largest that is accepted."""
    violation: str | None
    """What is wrong, in words; None if it is accepted."""


@dataclass(frozen=True)
class Report:
    """The results of all checks of a plan."""

    valid: bool
    """Whether every check holds, and the plan begins and ends where it must."""
    checks: list[CheckResult]
    """One result for each check."""
    margins: dict[str, float | None]
    """The worst margin of each check that measures one."""
    start: End
    """Where it begins."""
    goal: End
    """Where it ends."""
    notes: list[str] = field(default_factory=list)
    """Whose limits hold, and what no check covers, one line each."""

    def violations(self) -> list[str]:
        """All violations, one line each."""
        of_checks = [
            f"phase {one.violated_phase}: {one.check} at waypoint {one.violated_waypoint}: "
            f"{one.violation}"
            for one in self.checks
            if one.violation is not None
        ]
        ends = (("start", self.start), ("goal", self.goal))
        return of_checks + [f"{name}: {end.violation}" for name, end in ends if end.violation]

    def raise_if_refused(self) -> None:
        """Raises :class:`Refused` with all violations if there are any."""
        if not self.valid:
            raise Refused("; ".join(self.violations()))


@dataclass(frozen=True)
class Margins:
    """The worst margins of each chunk of a plan."""

    time: NDArray[np.float64]
    """Begin and end of each chunk, s, a row each."""
    of: dict[str, NDArray[np.float64]]
    """By name of the check, one number for each chunk; not a number where it was not measured,
    or where the chunk violates a check."""


@dataclass(frozen=True)
class Loads:
    """Centre of mass, contact forces and joint efforts along a plan."""

    time: NDArray[np.float64]
    """Time since the beginning of the plan, s."""
    centre_of_mass: NDArray[np.float64]
    """In the world, m, a row each."""
    balance_margin: NDArray[np.float64]
    """Distance of the centre of mass from the edge of the equilibrium region, m."""
    friction_use: NDArray[np.float64]
    """Largest share of the friction limit in use at a foot, 0 to 1."""
    torque_use: NDArray[np.float64]
    """Largest share of the effort limit in use at a joint, 0 to 1."""
    forces: NDArray[np.float64]
    """Forces of the ground on the left and the right foot in the world frame, N, an array
    (n, 2, 3); not a number for a foot that does not carry."""
    pressure_centres: NDArray[np.float64]
    """Centres of pressure of both feet in the world, m, an array (n, 2, 3)."""
    torques: NDArray[np.float64]
    """Efforts of the joints, N m or N, a row each."""


class Checker:
    """Checks walks of one robot. ``parameters`` may hold the tolerances, as ``[checker]``."""

    def __init__(
        self,
        robot: Robot | str | os.PathLike[str],
        parameters: ParameterTables | None = None,
    ) -> None:
        self.robot = robot if isinstance(robot, Robot) else Robot(robot)
        """The robot, whose limits hold."""
        self._parameters = parameters_of(parameters)

    def check(self, plan: Plan, scenario: Scenario | str | os.PathLike[str] | None = None) -> Report:
        """All checks of a plan. With a scenario it must answer that: its world, start, goal and
        tolerances hold. Without one the plan's own world, start and goal do."""
        if scenario is None:
            checker = _native.Checker(self.robot._native, plan.world._native, self._parameters)
            return _report(json.loads(checker.check(plan._native)))
        from surefoot.scenario import Scenario

        task = scenario if isinstance(scenario, Scenario) else Scenario(scenario)
        checker = _native.Checker(self.robot._native, task.world._native, task._parameters)
        ends = (task.start._numbers(), task.goal._all_numbers())
        return _report(json.loads(checker.check(plan._native, ends)))

    def margins(self, plan: Plan) -> Margins:
        """The worst margins of each chunk, in the plan's own world."""
        checker = _native.Checker(self.robot._native, plan.world._native, self._parameters)
        chunks = [chunk or {} for chunk in json.loads(checker.margins(plan._native))]
        names = list(dict.fromkeys(name for chunk in chunks for name in chunk))
        numbers = {name: [chunk.get(name) for chunk in chunks] for name in names}
        of = {name: np.array(column, dtype=np.float64) for name, column in numbers.items()}
        return Margins(plan.chunk_times, of)

    def loads(self, plan: Plan, rate_hz: float = 50.0) -> Loads:
        """Centre of mass, contact forces of least squares and joint efforts at a rate, in the
        plan's own world. They mean something for a plan that the checks accept."""
        if not 0.0 < rate_hz < float("inf"):
            raise ParameterError(f"rate_hz is {rate_hz}; it must be positive", parameter="rate_hz")
        checker = _native.Checker(self.robot._native, plan.world._native, self._parameters)
        loads: dict[str, Any] = checker.loads(plan._native, 1.0 / rate_hz)
        for name in ("forces", "pressure_centres"):
            loads[name] = loads[name].reshape(-1, 2, 3)
        return Loads(**loads)


def _report(found: dict[str, Any]) -> Report:
    return Report(
        valid=found["valid"],
        checks=[_check(one) for one in found["checks"]],
        margins=found["margins"],
        start=End(**found["start"]),
        goal=End(**found["goal"]),
        notes=found["notes"],
    )


def _check(found: dict[str, Any]) -> CheckResult:
    place = found.pop("violation")
    if place is None:
        return CheckResult(**found, violation=None)
    return CheckResult(
        **found,
        violation=place["detail"],
        violated_phase=place["phase"],
        violated_waypoint=place["waypoint"],
    )
