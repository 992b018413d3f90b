#!/usr/bin/env python3
"""Writes tests/data/pinocchio_hubo.json: Pinocchio's kinematics and gravity torques of the reference robot.

    pip install pin && tools/pinocchio_reference.py

For each of CONFIGURATIONS random configurations (fixed seed): the pose of every link, the centre of mass, the gravity
term of every joint, and for each foot the torques with which the robot stands still on that foot alone. On one foot the
wrench w at the sole follows from the six unactuated rows of  g = [0; tau] + J^T w,  and tau from the others; the
friction cone plays no part.
"""

import json
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

REPOSITORY = Path(__file__).resolve().parent.parent
ROBOT = Path("configs/robots/hubo/robot.toml")
OUTPUT = Path("tests/data/pinocchio_hubo.json")
CONFIGURATIONS = 50
SEED = 20240607
DECIMALS = 12
GRAVITY = 9.81


def load():
    """The robot file, the model with a free-flying root, and the links' names in file order."""
    robot_file = REPOSITORY / ROBOT
    robot = tomllib.loads(robot_file.read_text())
    urdf = ElementTree.parse(robot_file.parent / robot["urdf"]).getroot()
    for link in urdf.findall("link"):
        for collision in link.findall("collision"):  # Pinocchio's URDF parser complains about capsules
            link.remove(collision)
    model = pin.buildModelFromXML(ElementTree.tostring(urdf, encoding="unicode"), pin.JointModelFreeFlyer())
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    links = [f.name for f in model.frames if f.type == pin.FrameType.BODY]
    return robot, model, links


def random_configuration(model, rng):
    """Any root pose within 2 m of the origin, every joint within its limits."""
    q = np.empty(model.nq)
    q[:3] = rng.uniform(-2.0, 2.0, 3)
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    q[3:7] = quaternion if quaternion[3] >= 0.0 else -quaternion
    q[7:] = rng.uniform(model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
    # Rounded first, so that the file holds exactly the configuration that was evaluated.
    return np.round(q, DECIMALS)


def standing_torques(model, data, q, frame):
    """Joint torques of standing still on one foot alone; to be called after `computeJointJacobians`."""
    gravity = pin.computeGeneralizedGravity(model, data, q)
    jacobian = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    wrench = np.linalg.solve(jacobian[:, :6].T, gravity[:6])
    return gravity[6:] - jacobian[:, 6:].T @ wrench


def rounded(values):
    return [round(float(v), DECIMALS) + 0.0 for v in values]


def body_frame(model, name):
    return model.getFrameId(name, pin.FrameType.BODY)


def evaluate(robot, model, links, q):
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    poses = [pin.SE3ToXYZQUAT(data.oMf[body_frame(model, name)]) for name in links]
    feet = {foot["name"]: body_frame(model, foot["link"]) for foot in robot["feet"]}
    return {
        "root_xyz": rounded(q[:3]),
        "root_quat_xyzw": rounded(q[3:7]),
        "q": rounded(q[7:]),
        "com": rounded(pin.centerOfMass(model, data, q)),
        "gravity_torques": rounded(pin.computeGeneralizedGravity(model, data, q)[6:]),
        "standing_torques": {name: rounded(standing_torques(model, data, q, frame)) for name, frame in feet.items()},
        "links_xyz": [rounded(pose[:3]) for pose in poses],
        "links_quat_xyzw": [rounded(pose[3:] if pose[6] >= 0.0 else -pose[3:]) for pose in poses],
    }


def main():
    robot, model, links = load()
    rng = np.random.default_rng(SEED)
    reference = {
        "made_by": "tools/pinocchio_reference.py",
        "versions": {"pinocchio": pin.__version__, "numpy": np.__version__, "python": sys.version.split()[0]},
        "robot": str(ROBOT),
        "seed": SEED,
        "units": "m, rad, N m, kg; quaternions x, y, z, w with w >= 0; joints and links in the order of their names below",
        "gravity": GRAVITY,
        "mass": round(pin.computeTotalMass(model), DECIMALS),
        "joint_names": list(model.names)[2:],
        "link_names": links,
        "configurations": [evaluate(robot, model, links, random_configuration(model, rng)) for _ in range(CONFIGURATIONS)],
    }
    rows = reference.pop("configurations")
    head = json.dumps(reference, indent=1)[:-2]
    body = ",\n".join("  " + json.dumps(row, separators=(",", ":")) for row in rows)
    (REPOSITORY / OUTPUT).write_text(f'{head},\n "configurations": [\n{body}\n ]\n}}\n')


if __name__ == "__main__":
    main()
