#!/usr/bin/env python3
"""Routes of hubo's root in SE(3) by OMPL's RRT-Connect, through the boxes of Surefoot's worlds.

    pip install ompl==2.0.1 coal==3.0.3 numpy
    tools/peer_route.py [--trials N] [--seconds S] [WORLD GOAL_X ...]

A root pose is valid where the upper body (boxes and a ball of the size of hubo's links, arms hanging) is free and some
part of the world is within a leg's length: the condition C_N of stage P with the arms in their standing posture. A
world is named by its file below configs/worlds, without its ending. The walk begins at x = 0.7 m, y = 0.

What this cannot express: footholds, steps, balance, torques, a moving arm, and every motion of a leg. A route says
nothing about whether a walk follows it.
"""

import argparse
import statistics
import time
import tomllib
from pathlib import Path

import coal
import numpy as np
from ompl import base, geometric, util

WORLDS = Path(__file__).resolve().parent.parent / "configs/worlds"
DEFAULT = [("pass_under", 3.3), ("stepping_stones", 6.0), ("holes/low_beam", 4.3), ("holes/long_wall", 2.7)]
START_X = 0.7
# Of hubo: height of the root that stands, reach from the root to a sole, and the shapes of its links above the legs.
ROOT_HEIGHT, LEG_REACH = 0.75, 0.87
LINKS = [
    (coal.Box(0.10, 0.20, 0.12), (0.0, 0.0, 0.11)),
    (coal.Box(0.18, 0.26, 0.36), (0.005, 0.0, 0.38)),
    (coal.Sphere(0.08), (0.01, 0.0, 0.69)),
    (coal.Box(0.10, 0.10, 0.48), (0.0, 0.215, 0.29)),
    (coal.Box(0.10, 0.10, 0.48), (0.0, -0.215, 0.29)),
]


def rotation(roll, pitch, yaw):
    """The matrix of a rotation about x, then y, then z."""
    (sr, sp, sy), (cr, cp, cy) = np.sin([roll, pitch, yaw]), np.cos([roll, pitch, yaw])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return about_z @ about_y @ about_x


def load(name):
    """The shapes of a world of boxes, posed, and the bounds of them all."""
    shapes, corners = [], []
    for entry in tomllib.loads((WORLDS / f"{name}.toml").read_text())["shapes"]:
        if "box" not in entry:
            raise SystemExit(f"{name}: {entry['name']} is no box, and this script reads boxes only")
        half = np.array(entry["box"]["half_extents"])
        turned, at = rotation(*entry.get("rpy", (0.0, 0.0, 0.0))), np.array(entry["xyz"])
        shapes.append((coal.Box(*(2 * half)), coal.Transform3s(turned, at)))
        extent = np.abs(turned) @ half
        corners += [at - extent, at + extent]
    return shapes, (np.min(corners, axis=0), np.max(corners, axis=0))


class RootSpace:
    """C_N for the root of a robot in a world."""

    def __init__(self, shapes):
        self.shapes = shapes
        self.point = coal.Sphere(1e-3)
        self.tests = 0

    def is_valid(self, state):
        self.tests += 1
        turn = state.rotation()
        at = np.array([state.getX(), state.getY(), state.getZ()])
        matrix = quaternion_matrix(turn.w, turn.x, turn.y, turn.z)
        return self.is_free(matrix, at) and self.is_near(at)

    def is_free(self, matrix, at):
        for link, offset in LINKS:
            pose = coal.Transform3s(matrix, at + matrix @ np.array(offset))
            for shape, world in self.shapes:
                if coal.collide(link, pose, shape, world, coal.CollisionRequest(), coal.CollisionResult()):
                    return False
        return True

    def is_near(self, at):
        pose = coal.Transform3s(np.eye(3), at)
        return any(
            coal.distance(self.point, pose, shape, world, coal.DistanceRequest(), coal.DistanceResult()) <= LEG_REACH
            for shape, world in self.shapes
        )


def quaternion_matrix(w, x, y, z):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def search(shapes, bounds, goal_x, seconds):
    """One search: seconds and tests of root poses if it finds a route, else None."""
    space, root = base.SE3StateSpace(), RootSpace(shapes)
    box = base.RealVectorBounds(3)
    for axis in range(3):
        box.setLow(axis, float(bounds[0][axis]))
        box.setHigh(axis, float(max(bounds[1][axis], ROOT_HEIGHT + 0.5)))
    space.setBounds(box)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(root.is_valid)
    ends = []
    for x in (START_X, goal_x):
        end = space.allocState()
        end.setXYZ(x, 0.0, ROOT_HEIGHT)
        end.rotation().setIdentity()
        ends.append(end)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    begin = time.process_time()
    setup.solve(seconds)
    return (time.process_time() - begin, root.tests) if setup.haveExactSolutionPath() else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=20.0, help="limit of a search")
    parser.add_argument("worlds", nargs="*", metavar="WORLD GOAL_X")
    arguments = parser.parse_args()
    given = list(zip(arguments.worlds[::2], map(float, arguments.worlds[1::2])))
    util.noOutputHandler()
    util.RNG.setSeed(1)
    print("| World | Routes found | Median processor seconds | Median tests of root poses |\n| --- | --- | --- | --- |")
    for name, goal_x in given or DEFAULT:
        shapes, bounds = load(name)
        ends = [search(shapes, bounds, goal_x, arguments.seconds) for _ in range(arguments.trials)]
        found = [end for end in ends if end]
        medians = [statistics.median(values) for values in zip(*found)] or [float("nan")] * 2
        print(f"| {name} | {len(found)} of {len(ends)} | {medians[0]:.2f} | {medians[1]:.0f} |", flush=True)


if __name__ == "__main__":
    main()
