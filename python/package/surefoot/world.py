"""Worlds."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot import _native
from surefoot.errors import WorldError
from surefoot.robot import Mesh

FRICTION = 0.6
"""Coefficient of friction of a world for which none is stated."""


class World:
    """A validated world: fixed shapes with one coefficient of friction.

    ``world`` is the path of a world file, or the name of a world that the package carries
    (``surefoot.shipped("world")``). ``WorldBuilder``, ``from_heights`` and ``from_mesh`` make
    worlds in memory.
    """

    def __init__(self, world: str | os.PathLike[str]) -> None:
        self._native = _native.World.load(_native.resolve("world", world))

    @classmethod
    def _of(cls, native: _native.World) -> World:
        world = cls.__new__(cls)
        world._native = native
        return world

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        spacing: float,
        *,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        yaw: float = 0.0,
        friction: float = FRICTION,
    ) -> World:
        """The surface of a height map: ``heights[i, j]`` (m) is at x = j * spacing,
        y = i * spacing from ``origin``. Cells with a height that is not finite stay open."""
        builder = WorldBuilder(friction)
        return builder.heights("ground", heights, spacing, position=origin, rpy=(0, 0, yaw)).build()

    @classmethod
    def from_mesh(
        cls,
        mesh: Any = None,
        *,
        vertices: ArrayLike | None = None,
        faces: ArrayLike | None = None,
        friction: float = FRICTION,
    ) -> World:
        """A surface of triangles: arrays of vertices (m) and faces, or any object with attributes
        ``vertices`` and ``faces``, as trimesh's, counter-clockwise seen from outside."""
        if mesh is not None:
            vertices, faces = mesh.vertices, mesh.faces
        if vertices is None or faces is None:
            raise WorldError("give a mesh, or vertices and faces")
        return WorldBuilder(friction).mesh("mesh", vertices, faces).build()

    def __repr__(self) -> str:
        return f"<World of {len(self.shape_names)} shapes, friction {self.friction:g}>"

    @property
    def friction(self) -> float:
        """The coefficient of friction."""
        return self._native.friction

    @property
    def shape_names(self) -> list[str]:
        """The names of the shapes, in their order."""
        return self._native.shape_names

    @property
    def digest(self) -> str:
        """Digest of all that it was made of, hexadecimal."""
        return self._native.digest

    def meshes(self) -> list[Mesh]:
        """The surface of each shape, in the world's frame."""
        return [Mesh(*mesh) for mesh in self._native.meshes()]


class WorldBuilder:
    """Collects the shapes of a world in memory; :meth:`build` validates them.

    Each method adds a shape at a ``position`` (m) with a rotation: ``rpy``, roll, pitch and yaw
    (rad) about the fixed axes x, y, z, or ``quat``, a unit quaternion x, y, z, w.
    """

    def __init__(self, friction: float = FRICTION) -> None:
        self._native = _native.WorldBuilder(float(friction))

    def box(self, name: str, size: Sequence[float], **pose: Any) -> WorldBuilder:
        """A box with the full length of each side, centred on its position."""
        self._native.cuboid(name, _pose(**pose), _three("size", 0.5 * np.asarray(size, float)))
        return self

    def sphere(self, name: str, radius: float, **pose: Any) -> WorldBuilder:
        """A ball, centred on its position."""
        self._native.sphere(name, _pose(**pose), float(radius))
        return self

    def cylinder(self, name: str, radius: float, length: float, **pose: Any) -> WorldBuilder:
        """A cylinder along z with its full length, centred on its position."""
        self._native.cylinder(name, _pose(**pose), float(radius), float(length))
        return self

    def capsule(self, name: str, radius: float, length: float, **pose: Any) -> WorldBuilder:
        """A capsule along z; ``length`` is that of its cylindrical part."""
        self._native.capsule(name, _pose(**pose), float(radius), float(length))
        return self

    def convex(self, name: str, points: ArrayLike, **pose: Any) -> WorldBuilder:
        """The convex hull of points."""
        self._native.convex(name, _pose(**pose), _matrix("points", points))
        return self

    def mesh(
        self, name: str, vertices: ArrayLike, faces: ArrayLike, **pose: Any
    ) -> WorldBuilder:
        """A surface of triangles, counter-clockwise seen from outside."""
        self._native.mesh(name, _pose(**pose), _matrix("vertices", vertices), _faces(faces))
        return self

    def heights(
        self, name: str, heights: ArrayLike, spacing: float, **pose: Any
    ) -> WorldBuilder:
        """The surface of a height map: ``heights[i, j]`` is at x = j * spacing,
        y = i * spacing. Cells with a height that is not finite stay open."""
        if not spacing > 0.0:
            raise WorldError(f"shape '{name}': the spacing is {spacing}; it must be positive")
        matrix = _matrix("heights", heights)
        self._native.height_map(name, _pose(**pose), matrix, float(spacing))
        return self

    def build(self) -> World:
        """The world. Raises :class:`WorldError` for the first shape that is out of order."""
        return World._of(self._native.build())


def _pose(
    position: Sequence[float] = (0.0, 0.0, 0.0),
    rpy: Sequence[float] | None = None,
    quat: Sequence[float] | None = None,
) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    if rpy is not None and quat is not None:
        raise WorldError("give a rotation as rpy or as quat, not both")
    if quat is not None:
        x, y, z, w = (float(number) for number in quat)
        return _three("position", position), (x, y, z, w)
    half = 0.5 * np.asarray(_three("rpy", (0.0, 0.0, 0.0) if rpy is None else rpy))
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    rotation = (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    x, y, z, w = (float(number) for number in rotation)
    return _three("position", position), (x, y, z, w)


def _three(name: str, numbers: Any) -> tuple[float, float, float]:
    try:
        x, y, z = (float(number) for number in numbers)
    except (TypeError, ValueError):
        raise WorldError(f"{name} must be three numbers, not {numbers!r}") from None
    return (x, y, z)


def _matrix(name: str, numbers: ArrayLike) -> np.ndarray[Any, np.dtype[np.float64]]:
    matrix = np.ascontiguousarray(numbers, dtype=np.float64)
    if matrix.ndim != 2:
        raise WorldError(f"{name} has the shape {matrix.shape}; it must be a matrix")
    return matrix


def _faces(numbers: ArrayLike) -> np.ndarray[Any, np.dtype[np.uint32]]:
    faces = np.asarray(numbers)
    if not np.issubdtype(faces.dtype, np.integer) or faces.ndim != 2:
        raise WorldError("faces must be a matrix of vertex indices")
    if faces.size and (faces.min() < 0 or faces.max() > np.iinfo(np.uint32).max):
        raise WorldError("faces hold an index that no vertex has")
    return np.ascontiguousarray(faces, dtype=np.uint32)
