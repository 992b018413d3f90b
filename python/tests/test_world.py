"""Worlds from arrays and shapes."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import surefoot


def walk(robot: surefoot.Robot, world: surefoot.World) -> surefoot.Plan:
    """A walk of half a metre, accepted by the checker."""
    plan = surefoot.plan(robot, world, start=(0, 0, 0), goal=(0.5, 0, 0))
    report = surefoot.Checker(robot).check(plan)
    assert report.valid, report.violations()
    return plan


def test_a_height_map_is_walked_and_saved(robot: surefoot.Robot, tmp_path: Path) -> None:
    heights = np.zeros((11, 21))
    heights[:, 12:] = -0.05
    heights[0, 0] = np.nan
    world = surefoot.World.from_heights(heights, 0.1, origin=(-0.5, -0.5, 0))
    (mesh,) = world.meshes()
    assert len(mesh.faces) == 2 * 10 * 20 - 2, "the cell of the unknown height is open"
    assert np.allclose(mesh.vertices.min(axis=0), (-0.5, -0.5, -0.05))
    plan = walk(robot, world)
    plan.save(tmp_path / "walk.json")
    assert (tmp_path / "walk.0.obj").is_file()
    loaded = surefoot.Plan.load(tmp_path / "walk.json")
    (again,) = loaded.world.meshes()
    assert np.allclose(again.vertices, mesh.vertices, atol=1e-6)
    assert surefoot.Checker(robot).check(loaded).valid


def test_a_mesh_may_be_arrays_or_an_object_with_them(robot: surefoot.Robot) -> None:
    vertices = [(-1, -1, 0), (2, -1, 0), (2, 1, 0), (-1, 1, 0)]
    faces = [(0, 1, 2), (0, 2, 3)]
    world = surefoot.World.from_mesh(vertices=vertices, faces=faces, friction=0.7)
    mesh = SimpleNamespace(vertices=np.array(vertices, np.float32), faces=np.array(faces, np.int64))
    assert surefoot.World.from_mesh(mesh, friction=0.7).digest == world.digest
    assert world.friction == 0.7 and walk(robot, world).world.shape_names == ["mesh"]


def test_boxes_and_other_shapes(robot: surefoot.Robot) -> None:
    world = (
        surefoot.WorldBuilder()
        .box("floor", (4, 2, 0.5), position=(1, 0, -0.25))
        .cylinder("log", 0.1, 1.0, position=(0.2, 0.9, 0.1), rpy=(np.pi / 2, 0, 0))
        .sphere("ball", 0.1, position=(0.2, -0.9, 0.1))
        .capsule("rail", 0.05, 0.5, position=(1, 0.8, 0.5))
        .convex("tent", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], position=(3, 2, 0))
        .build()
    )
    assert world.shape_names == ["floor", "log", "ball", "rail", "tent"]
    log = world.meshes()[1].vertices
    assert np.allclose(np.ptp(log, axis=0), (0.2, 1.0, 0.2), atol=1e-9), "it lies along y"
    walk(robot, world)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: surefoot.WorldBuilder().build(), "needs at least one shape"),
        (lambda: surefoot.WorldBuilder(-1).sphere("a", 1).build(), "friction is -1"),
        (lambda: surefoot.WorldBuilder().sphere("a", -1).build(), "shape 'a'"),
        (lambda: surefoot.WorldBuilder().box("a", (1, 1)), "size must be three numbers"),
        (lambda: surefoot.WorldBuilder().mesh("a", [(0, 0, 0)], [(0, 1, 2)]).build(), "vertex 1"),
        (lambda: surefoot.WorldBuilder().mesh("a", [(0, 0)], [(0, 1, 2)]), "3 columns"),
        (lambda: surefoot.WorldBuilder().mesh("a", [(0, 0, 0)], [(0.5, 1, 2)]), "indices"),
        (lambda: surefoot.WorldBuilder().mesh("a", [(0, 0, 0)], [(-1, 1, 2)]), "index"),
        (lambda: surefoot.World.from_heights([[0, 0], [0, 0]], 0), "spacing is 0"),
        (lambda: surefoot.World.from_heights([0, 0], 1), "must be a matrix"),
        (lambda: surefoot.World.from_heights(np.full((3, 3), np.nan), 1), "no triangle"),
        (lambda: surefoot.World.from_mesh(), "give a mesh"),
        (
            lambda: surefoot.WorldBuilder().sphere("a", 1, rpy=(0, 0, 1), quat=(0, 0, 0, 1)),
            "not both",
        ),
    ],
)
def test_what_is_out_of_order_is_named(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]
