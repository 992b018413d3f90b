"""Robots."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surefoot import _native


@dataclass(frozen=True)
class Limits:
    """Limits of the moving joints, in the order of :attr:`Robot.joint_names`."""

    lower: NDArray[np.float64]
    """Smallest positions, rad or m."""
    upper: NDArray[np.float64]
    """Largest positions, rad or m."""
    velocity: NDArray[np.float64]
    """Largest velocities, rad/s or m/s; infinite without a limit."""
    acceleration: NDArray[np.float64]
    """Largest accelerations, rad/s2 or m/s2."""
    effort: NDArray[np.float64]
    """Largest efforts, N m or N; infinite without a limit."""


@dataclass(frozen=True)
class Sole:
    """The sole of a foot."""

    foot: str
    """``left`` or ``right``."""
    link: str
    """The link that carries it."""
    polygon: NDArray[np.float64]
    """Its outline in the sole frame, counter-clockwise, m."""


@dataclass(frozen=True)
class Mesh:
    """A surface of triangles."""

    name: str
    """The link or the shape that it belongs to."""
    vertices: NDArray[np.float64]
    """Points, a row each, m."""
    faces: NDArray[np.uint32]
    """Indices of three vertices, counter-clockwise seen from outside, a row for each triangle."""


class Robot:
    """A validated biped: what a URDF and the ``robot.toml`` beside it say.

    ``robot`` is the path of a ``robot.toml``, or the name of a robot that the package carries
    (``surefoot.shipped("robot")``).
    """

    def __init__(self, robot: str | os.PathLike[str]) -> None:
        self._native = _native.Robot.load(_native.resolve("robot", robot))

    @classmethod
    def _of(cls, native: _native.Robot) -> Robot:
        robot = cls.__new__(cls)
        robot._native = native
        return robot

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {len(self.joint_names)} joints, {self.mass:.1f} kg>"

    @property
    def name(self) -> str:
        """The name in the URDF."""
        return self._native.name

    @property
    def mass(self) -> float:
        """The mass of all links, kg."""
        return self._native.mass

    @property
    def urdf_path(self) -> Path:
        """The URDF."""
        return Path(self._native.urdf_path)

    @property
    def digest(self) -> str:
        """Digest of all files that it was read from, hexadecimal."""
        return self._native.digest

    @property
    def joint_names(self) -> list[str]:
        """The moving joints, in the order of every array of joints."""
        return self._native.joint_names

    @property
    def link_names(self) -> list[str]:
        """The links, parents before children; links that are fixed to each other may be one."""
        return self._native.link_names

    @property
    def standing(self) -> NDArray[np.float64]:
        """The joints of the standing posture, rad or m."""
        return self._native.standing

    @property
    def limits(self) -> Limits:
        """The limits of the moving joints."""
        native = self._native
        return Limits(
            native.lower, native.upper, native.velocity, native.acceleration, native.effort
        )

    @property
    def soles(self) -> list[Sole]:
        """The soles of the left and the right foot."""
        return [Sole(*sole) for sole in self._native.soles]

    def link_poses(
        self,
        root_positions: NDArray[np.float64],
        root_rotations: NDArray[np.float64],
        joints: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Poses of all links in the world, for n configurations: an array (n, links, 7) of
        position (m) and unit quaternion x, y, z, w."""
        rows = [
            np.ascontiguousarray(np.atleast_2d(array), dtype=np.float64)
            for array in (root_positions, root_rotations, joints)
        ]
        poses = self._native.link_poses(*rows)
        return poses.reshape(len(rows[0]), len(self.link_names), 7)

    def link_meshes(self) -> list[Mesh]:
        """The collision surface of each link, in the link's frame. Links without are left out."""
        return [Mesh(*mesh) for mesh in self._native.link_meshes()]
