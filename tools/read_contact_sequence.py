"""Reads a contact sequence into Pinocchio and checks it: an example for trajectory optimisers.

    pip install pin
    surefoot export PLAN.json --to contacts --hz 50 --out contacts.json
    python3 tools/read_contact_sequence.py contacts.json

A Crocoddyl or OCS2 problem needs the same parts: `model`, the states `x`, the feet in contact at
each knot with their placements, and the wrenches as references or warm start.
"""

import dataclasses
import json
import pathlib
import sys

import numpy as np
import pinocchio as pin


@dataclasses.dataclass
class Sequence:
    """A contact sequence in Pinocchio's terms."""

    model: pin.Model
    times: np.ndarray
    # One row a knot: position, quaternion x y z w, joints; velocity of the root in its own frame.
    q: np.ndarray
    v: np.ndarray
    com: np.ndarray
    # For each knot the wrench on each stance foot, by frame, in the frame's own axes.
    wrenches: list
    # For each knot the placement of each stance foot, by frame.
    placements: list


def build_model(robot):
    """The robot with a free root, with its locked joints fixed, and a frame for each sole."""
    model = pin.buildModelFromUrdf(robot["urdf"], pin.JointModelFreeFlyer())
    moving = set(robot["joint_names"])
    locked = [j for j in range(2, model.njoints) if model.names[j] not in moving]
    reference = pin.neutral(model)
    for joint in locked:
        position = robot["locked_joints"].get(model.names[joint], 0.0)
        set_joint(model, reference, joint, position)
    model = pin.buildReducedModel(model, locked, reference)
    for foot in robot["feet"]:
        link = model.frames[model.getFrameId(foot["link"])]
        placement = link.placement * pose(foot["link_from_sole"])
        name = f"{foot['name']}_sole"
        frame = pin.Frame(name, link.parentJoint, placement, pin.FrameType.OP_FRAME)
        model.addFrame(frame)
    return model


def set_joint(model, q, joint, position):
    """Sets a joint of one degree of freedom; a continuous one is stored as cosine and sine."""
    at = model.idx_qs[joint]
    if model.nqs[joint] == 2:
        q[at : at + 2] = np.cos(position), np.sin(position)
    else:
        q[at] = position


def pose(block):
    return pin.XYZQUATToSE3(np.array(block["xyz"] + block["quat_xyzw"]))


def read(path):
    data = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    assert data["schema"] == "surefoot-contact-sequence/1", data["schema"]
    robot, knots = data["robot"], data["knots"]
    model = build_model(robot)
    joints = [model.getJointId(name) for name in robot["joint_names"]]
    q = np.tile(pin.neutral(model), (len(knots), 1))
    v = np.zeros((len(knots), model.nv))
    wrenches, placements = [], []
    for row, knot in enumerate(knots):
        root = pose(knot["root_pose"])
        q[row, :7] = pin.SE3ToXYZQUAT(root)
        v[row, :3] = root.rotation.T @ np.array(knot["v"][:3])
        v[row, 3:6] = root.rotation.T @ np.array(knot["v"][3:6])
        for joint, position, speed in zip(joints, knot["q"], knot["v"][6:]):
            set_joint(model, q[row], joint, position)
            v[row, model.idx_vs[joint]] = speed
        feet = {}
        for contact in data["phases"][knot["phase"]]["contacts"]:
            feet[f"{contact['foot']}_sole"] = pose(contact["sole_pose"])
        placements.append(feet)
        forces = {}
        for wrench in knot["wrenches"]:
            name = f"{wrench['foot']}_sole"
            turn = feet[name].rotation.T
            forces[name] = pin.Force(
                turn @ np.array(wrench["force"]), turn @ np.array(wrench["moment"])
            )
        wrenches.append(forces)
    times = np.array([knot["t"] for knot in knots])
    com = np.array([knot["com"] for knot in knots])
    return Sequence(model, times, q, v, com, wrenches, placements)


def residuals(sequence):
    """How far feet and centre of mass are off (m), and what the root lacks to stand (N, N m)."""
    model, data = sequence.model, sequence.model.createData()
    feet_off = com_off = root_lack = 0.0
    for row, q in enumerate(sequence.q):
        pin.framesForwardKinematics(model, data, q)
        for name, placement in sequence.placements[row].items():
            actual = data.oMf[model.getFrameId(name)]
            feet_off = max(feet_off, np.linalg.norm(actual.translation - placement.translation))
        off = pin.centerOfMass(model, data, q) - sequence.com[row]
        com_off = max(com_off, np.linalg.norm(off))
        external = [pin.Force.Zero() for _ in range(model.njoints)]
        for name, wrench in sequence.wrenches[row].items():
            frame = model.frames[model.getFrameId(name)]
            external[frame.parentJoint] += frame.placement.act(wrench)
        still = np.zeros(model.nv)
        efforts = pin.rnea(model, data, q, still, still, external)
        root_lack = max(root_lack, np.abs(efforts[:6]).max())
    return feet_off, com_off, root_lack


def main():
    sequence = read(sys.argv[1])
    feet_off, com_off, root_lack = residuals(sequence)
    print(f"{len(sequence.times)} knots, {sequence.model.nv} velocities, {sequence.times[-1]:.2f} s")
    print(f"feet off by at most {1e3 * feet_off:.3f} mm, centre of mass by {1e3 * com_off:.3f} mm")
    print(f"largest residual of the root's equilibrium {root_lack:.4f} N or N m")
    weight = 9.81 * pin.computeTotalMass(sequence.model)
    assert feet_off < 2e-3 and com_off < 1e-3 and root_lack < 2e-3 * weight, "not what it says"


if __name__ == "__main__":
    main()
