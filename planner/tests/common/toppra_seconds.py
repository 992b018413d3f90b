"""Times a path with toppra, as the tests of planner/tests/timing_oracle.rs ask on standard input.

Prints the duration of the fastest motion from rest to rest (s). A problem is either
{"grid": [...], "sides": [[[n_x, n_u, offset], ...], ...]}, the sides of the sets of squared speeds
x and accelerations u that are allowed at each point of the grid, or {"grid", "waves", "speed",
"acceleration"}: joints that move as a sin(b s + c), with equal limits. Exit code 9: no toppra.
"""

import json
import sys

try:
    import numpy as np
    import toppra
    from toppra.constraint import canlinear_colloc_to_interpolate
except ImportError:
    sys.exit(9)

INTERPOLATION = toppra.constraint.DiscretizationType.Interpolation


class Waves(toppra.interpolator.AbstractGeometricPath):
    """Joints at `a sin(b s + c)`."""

    def __init__(self, waves, end):
        self.a, self.b, self.c = np.array(waves).T
        self.end = end

    def __call__(self, path_positions, order=0):
        angle = np.multiply.outer(path_positions, self.b) + self.c + order * np.pi / 2
        return self.a * self.b**order * np.sin(angle)

    @property
    def dof(self):
        return len(self.a)

    @property
    def path_interval(self):
        return np.array([0.0, self.end])


class Sides(toppra.constraint.LinearConstraint):
    """Half-planes of `(x, u)` at each point of the grid."""

    def __init__(self, sides):
        super().__init__()
        self.set_discretization_type(INTERPOLATION)
        most = max(len(rows) for rows in sides)
        self.rows = np.array([rows + [rows[0]] * (most - len(rows)) for rows in sides])
        self._format_string = ""

    def compute_constraint_params(self, path, gridpoints, *_):
        count = len(gridpoints)
        a, b = np.tile([0.0, 1.0], (count, 1)), np.tile([1.0, 0.0], (count, 1))
        params = (a, b, np.zeros((count, 2)), self.rows[:, :, :2], self.rows[:, :, 2], None, None)
        return canlinear_colloc_to_interpolate(*params, gridpoints, identical=False)


def constraints(problem):
    if "sides" in problem:
        return [Sides(problem["sides"])]
    dof = len(problem["waves"])
    limits = [np.outer(np.full(dof, problem[name]), [-1, 1]) for name in ("speed", "acceleration")]
    return [
        toppra.constraint.JointVelocityConstraint(limits[0]),
        toppra.constraint.JointAccelerationConstraint(
            limits[1], discretization_scheme=INTERPOLATION
        ),
    ]


def seconds(problem):
    grid = np.array(problem["grid"])
    path = Waves(problem.get("waves", [[1.0, 1.0, 0.0]]), grid[-1])
    solver = toppra.algorithm.TOPPRA(
        constraints(problem), path, gridpoints=grid, solver_wrapper="seidel"
    )
    _, speeds, _ = solver.compute_parameterization(0, 0)
    if speeds is None:
        sys.exit("toppra finds no motion")
    return float(np.sum(2 * np.diff(grid) / (speeds[:-1] + speeds[1:])))


print(seconds(json.load(sys.stdin)))
