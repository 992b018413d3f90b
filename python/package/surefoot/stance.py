"""Where a walk begins and ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from surefoot.errors import ParameterError


@dataclass(frozen=True)
class Stance:
    """Both soles side by side on the ground."""

    x: float
    """Midpoint between both sole frames in the world, m."""
    y: float
    z: float
    yaw: float = 0.0
    """Heading in the world, rad."""
    width: float | None = None
    """Lateral distance between both sole frames, m; without one, that of the robot as it stands."""

    def _numbers(self) -> tuple[float, float, float, float, float | None]:
        x, y, z, yaw = map(float, (self.x, self.y, self.z, self.yaw))
        return (x, y, z, yaw, None if self.width is None else float(self.width))


@dataclass(frozen=True)
class Goal(Stance):
    """A stance to reach, with tolerances."""

    position_tolerance: float = 0.10
    """How far each sole's centre may be from its place, m."""
    yaw_tolerance: float = 0.35
    """How far each sole's heading may be off, rad."""

    def _all_numbers(self) -> tuple[float, float, float, float, float | None, float, float]:
        return (*self._numbers(), float(self.position_tolerance), float(self.yaw_tolerance))


def stance_of(value: Stance | Sequence[float]) -> Stance:
    """A stance, or one from x, y, z and maybe yaw."""
    return value if isinstance(value, Stance) else Stance(*_numbers("start", value))


def goal_of(value: Stance | Sequence[float]) -> Goal:
    """A goal, one at a stance, or one from x, y, z and maybe yaw."""
    if isinstance(value, Goal):
        return value
    if isinstance(value, Stance):
        return Goal(*value._numbers())
    return Goal(*_numbers("goal", value))


def _numbers(name: str, value: Sequence[float]) -> list[float]:
    try:
        numbers = [float(number) for number in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (3, 4):
        message = f"{name}: give x, y, z and maybe yaw, or a Stance, not {value!r}"
        raise ParameterError(message, parameter=name)
    return numbers
