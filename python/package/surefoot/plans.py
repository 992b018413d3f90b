"""Plans."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot import _native
from surefoot.errors import ParameterError
from surefoot.robot import Robot
from surefoot.world import World

FEET = ("left", "right")
"""The feet, in the order of every array of feet."""


@dataclass(frozen=True)
class Foothold:
    """A place where a foot stands."""

    foot: str
    """``left`` or ``right``."""
    time: float
    """When the foot is set down, s since the beginning of the plan; 0 for the start stance."""
    position: NDArray[np.float64]
    """Position of the sole frame in the world, m."""
    rotation: NDArray[np.float64]
    """Rotation of the sole frame in the world, unit quaternion x, y, z, w."""
    polygon: NDArray[np.float64]
    """The supported part of the sole in the sole frame, counter-clockwise, m."""


class Footholds(Sequence[Foothold]):
    """The start stance, then each landing in order; as arrays and one by one."""

    def __init__(
        self,
        foot: NDArray[np.uint8],
        time: NDArray[np.float64],
        position: NDArray[np.float64],
        rotation: NDArray[np.float64],
        polygons: list[NDArray[np.float64]],
    ) -> None:
        self.foot = foot
        """Index into :data:`FEET`."""
        self.time = time
        """When the foot is set down, s."""
        self.position = position
        """Sole positions in the world, a row each, m."""
        self.rotation = rotation
        """Sole rotations in the world, unit quaternions x, y, z, w."""
        self.polygons = polygons
        """The supported part of each sole."""

    def __len__(self) -> int:
        return len(self.time)

    @overload
    def __getitem__(self, at: int) -> Foothold: ...
    @overload
    def __getitem__(self, at: slice) -> list[Foothold]: ...
    def __getitem__(self, at: int | slice) -> Foothold | list[Foothold]:
        if isinstance(at, slice):
            return [self[index] for index in range(*at.indices(len(self)))]
        at = range(len(self))[at]
        foot = FEET[self.foot[at]]
        place = (self.position[at], self.rotation[at], self.polygons[at])
        return Foothold(foot, float(self.time[at]), *place)

    def __iter__(self) -> Iterator[Foothold]:
        return (self[at] for at in range(len(self)))


@dataclass(frozen=True)
class Waypoints:
    """The configurations that a plan goes through."""

    time: NDArray[np.float64]
    """Time since the beginning of the plan, s."""
    root_position: NDArray[np.float64]
    """Position of the root link in the world, m, a row each."""
    root_rotation: NDArray[np.float64]
    """Rotation of the root link in the world, unit quaternions x, y, z, w."""
    joints: NDArray[np.float64]
    """Joint positions in the order of :attr:`Robot.joint_names`, rad or m."""
    contacts: NDArray[np.bool_]
    """Whether the left and the right foot carry the robot during the motion that leads there."""

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True)
class Samples(Waypoints):
    """A plan at a fixed rate."""

    root_velocity: NDArray[np.float64]
    """Velocity of the root's origin (m/s) and angular velocity (rad/s), along the world's axes."""
    joint_velocity: NDArray[np.float64]
    """Joint velocities, rad/s or m/s."""
    root_acceleration: NDArray[np.float64]
    """The derivative of ``root_velocity``."""
    joint_acceleration: NDArray[np.float64]
    """The derivative of ``joint_velocity``."""
    torque: NDArray[np.float64]
    """Feed-forward joint efforts, N m or N; 0 in a quasi-static plan."""

    def __getitem__(self, at: int | slice) -> Samples:
        return Samples(**{field.name: getattr(self, field.name)[at] for field in fields(self)})


class Plan:
    """A whole-body walk. It does not change."""

    def __init__(
        self,
        native: _native.Plan,
        stats: dict[str, Any],
        route: NDArray[np.float64],
        digest: str | None,
    ) -> None:
        self._native = native
        self.stats = stats
        """Statistics of the search: ``work`` (units), ``sequences``, ... Empty if loaded."""
        self.route = route
        """The guide route, midway between the soles, m, a row each. Empty if loaded."""
        self.digest = digest
        """Digest of the chunk stream, hexadecimal: equal plans have equal digests. None for a
        plan that was loaded, since a plan file holds less than the stream."""

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Plan:
        """Loads a plan file with its robot and its world. It need not come from Surefoot."""
        return cls(_native.Plan.load(path), {}, np.zeros((0, 3)), None)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Saves the plan (``biped-plan/1``). The file names the URDF and the meshes by relative
        paths; a mesh in memory becomes an OBJ file beside it, in single precision."""
        self._native.save(path)

    def __repr__(self) -> str:
        return (
            f"<Plan of {len(self.footholds) - 2} steps, {len(self.waypoints)} waypoints, "
            f"{self.duration:.1f} s>"
        )

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self._native.duration

    @cached_property
    def robot(self) -> Robot:
        """The robot that it moves."""
        return Robot._of(self._native.robot())

    @cached_property
    def world(self) -> World:
        """The world that it was planned in."""
        return World._of(self._native.world())

    @property
    def joint_names(self) -> list[str]:
        """The moving joints, in the order of every array of joints."""
        return self.robot.joint_names

    @cached_property
    def footholds(self) -> Footholds:
        """The start stance, then each landing in order."""
        return Footholds(*self._native.footholds())

    @cached_property
    def waypoints(self) -> Waypoints:
        """All waypoints. Each is statically stable in a quasi-static plan."""
        return Waypoints(**self._native.arrays())

    @cached_property
    def chunk_times(self) -> NDArray[np.float64]:
        """Begin and end of each chunk, s, a row each."""
        return self._native.chunk_times()

    def at(self, time: float | ArrayLike) -> Samples:
        """The motion at times (s), clamped to the duration."""
        times = np.ascontiguousarray(np.atleast_1d(time), dtype=np.float64)
        return Samples(**self._native.sample(times))

    def sample(self, rate_hz: float) -> Samples:
        """The motion at a rate: at 0, 1 / rate_hz, ... and at the end of the plan."""
        if not 0.0 < rate_hz < float("inf"):
            raise ParameterError(f"rate_hz is {rate_hz}; it must be positive", parameter="rate_hz")
        count = int(np.floor(self.duration * rate_hz))
        times = np.arange(count + 1) / rate_hz
        if times[-1] < self.duration:
            times = np.append(times, self.duration)
        return self.at(times)
