"""Checks the arrays of an export with NumPy, and that its table holds the same numbers.

    check_npz.py WALK.npz WALK.csv
"""

import sys

import numpy as np


def check_shapes(walk):
    count = len(walk["time"])
    joints = len(walk["joint_names"])
    bodies = len(walk["body_names"])
    assert np.allclose(walk["time"], np.arange(count) / walk["fps"])
    for name in ["position", "velocity", "acceleration", "effort"]:
        assert walk[f"joint_{name}"].shape == (count, joints)
    assert walk["root_velocity"].shape == (count, 6)
    assert walk["contacts"].shape == (count, 2) and walk["contacts"].dtype == bool
    assert list(walk["contact_names"]) == ["left", "right"]
    assert walk["body_position"].shape == (count, bodies, 3)
    assert str(walk["quaternion_order"]) == "wxyz"
    assert str(walk["effort_source"]) == "static" and len(str(walk["plan_digest"])) == 64
    for name in walk.files:
        if walk[name].dtype.kind == "f":
            assert np.isfinite(walk[name]).all(), name


def check_bodies(walk):
    """The root is a body, and velocities are the differences of positions."""
    root = walk["body_position"][:, :, :] == walk["root_position"][:, None, :]
    assert root.all(axis=(0, 2)).any()
    steps = np.diff(walk["body_position"], axis=0) * walk["fps"]
    speeds = walk["body_velocity"]
    assert np.abs(steps - speeds[:-1]).mean() < 0.1 * np.abs(speeds).mean()
    norms = np.linalg.norm(walk["body_rotation"], axis=2)
    assert np.allclose(norms, 1.0)


def check_table(walk, table):
    with open(table, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    rows = np.loadtxt(table, delimiter=",", skiprows=1)
    columns = dict(zip(names, rows.T))
    for at, joint in enumerate(walk["joint_names"]):
        assert (columns[f"position:{joint}"] == walk["joint_position"][:, at]).all()
        assert (columns[f"static_effort:{joint}"] == walk["joint_effort"][:, at]).all()
    assert (columns["root_qw"] == walk["root_rotation"][:, 0]).all()
    assert (columns["contact:right"] == walk["contacts"][:, 1]).all()


def main():
    walk = np.load(sys.argv[1])
    check_shapes(walk)
    check_bodies(walk)
    check_table(walk, sys.argv[2])


main()
