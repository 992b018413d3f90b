"""Checks keyframes with MuJoCo: the feet stand where the contact sequence says.

    check_mujoco.py KEYFRAMES.xml CONTACTS.json

The model is the robot's URDF without shapes, with a free joint above its root.
"""

import json
import pathlib
import sys
import xml.etree.ElementTree as ET

import mujoco
import numpy as np


def model_of(robot):
    """The robot as MuJoCo reads its URDF."""
    tree = ET.parse(robot["urdf"]).getroot()
    for link in tree.findall("link"):
        for name in ["visual", "collision"]:
            for element in link.findall(name):
                link.remove(element)
    for joint in tree.findall("joint"):
        if joint.get("name") in robot["locked_joints"]:
            joint.set("type", "fixed")
    options = ET.SubElement(ET.SubElement(tree, "mujoco"), "compiler")
    options.set("fusestatic", "false")
    options.set("inertiafromgeom", "false")
    options.set("balanceinertia", "true")
    options.set("boundmass", "1e-9")
    options.set("boundinertia", "1e-9")
    ET.SubElement(tree, "link", name="world")
    free = ET.SubElement(tree, "joint", name="free", type="floating")
    ET.SubElement(free, "parent", link="world")
    ET.SubElement(free, "child", link=robot["root_link"])
    return mujoco.MjSpec.from_string(ET.tostring(tree, encoding="unicode"))


def with_keyframes(spec, keyframes):
    """The model with the keyframes of an export, as an include would add them."""
    spec.compile()
    tree = ET.fromstring(spec.to_xml())
    tree.append(keyframes.find("keyframe"))
    return mujoco.MjModel.from_xml_string(ET.tostring(tree, encoding="unicode"))


def rotation(quat_xyzw):
    matrix = np.zeros(9)
    x, y, z, w = quat_xyzw
    mujoco.mju_quat2Mat(matrix, np.array([w, x, y, z]))
    return matrix.reshape(3, 3)


def main():
    sequence = json.loads(pathlib.Path(sys.argv[2]).read_text(encoding="utf-8"))
    robot = sequence["robot"]
    model = with_keyframes(model_of(robot), ET.parse(sys.argv[1]).getroot())
    joints = [model.joint(at).name for at in range(1, model.njnt)]
    assert joints == robot["joint_names"], (joints, robot["joint_names"])
    data = mujoco.MjData(model)
    assert model.nkey == len(sequence["knots"])
    feet = {foot["name"]: foot for foot in robot["feet"]}
    for key, knot in enumerate(sequence["knots"]):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        for contact in sequence["phases"][knot["phase"]]["contacts"]:
            foot = feet[contact["foot"]]
            body = data.body(foot["link"])
            sole = body.xpos + body.xmat.reshape(3, 3) @ foot["link_from_sole"]["xyz"]
            error = np.linalg.norm(sole - contact["sole_pose"]["xyz"])
            assert error < 2e-3, (key, contact["foot"], error)
        com = data.subtree_com[0]
        assert np.linalg.norm(com - knot["com"]) < 1e-3, (key, com, knot["com"])
        velocity = np.zeros(6)
        root = model.body(robot["root_link"]).id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, root, velocity, 0)
        assert np.allclose(velocity[:3], knot["v"][3:6], atol=1e-9), (velocity, knot["v"][:6])
        assert np.allclose(velocity[3:], knot["v"][:3], atol=1e-9), (velocity, knot["v"][:6])


main()
