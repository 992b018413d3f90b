#!/usr/bin/env python3
"""Replays exported plans in MuJoCo: does the robot stand at the plan's own times?

usage: replay_mujoco.py PLAN.json [PLAN.json ...] [--disturb SEED]

The base is free. Each joint follows the plan by a PD controller with the plan's feed-forward
torque, within the effort limits. The soles are prisms on the plan's sole polygons, with the
friction of the plan's world; no other link touches anything. Nothing holds the base, and time is
not slowed down. With --disturb masses vary by 5 %, friction by 20 %, commands come up to 4 ms late.

exit: 0 all stand, 1 one falls, 2 a plan cannot be replayed. Needs `pip install mujoco`.
"""

import argparse
import dataclasses
import json
import math
import random
import struct
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

try:
    import mujoco
    import numpy as np
except ImportError as error:
    print(f"cannot replay: {error}; pip install mujoco", file=sys.stderr)
    sys.exit(2)

# Simulation step, s.
STEP = 0.0005
# Proportional gain of a joint over its effort limit, 1/rad, and derivative gain over that, s. A robot
# that stands on stiff ankles sways at about 3 Hz; with a derivative gain of 0.02 s that sway is
# damped by a fifth of the critical damping, and Talos rocks on its edges until it falls.
STIFFNESS, DAMPING = 100.0, 0.05
# Reflected inertia of a motor over the joint's effort limit, s2.
ARMATURE = 8e-4
# Time constant of a contact, s, and its damping ratio: soles and ground are stiff. With MuJoCo's
# default of 20 ms, soles of 7 cm sink and tilt until the robot falls. A foot that turns in a step of
# the simulation without contact goes on to turn for as long: by 1.2 mrad with 4 ms in a single
# support that unloads it, by 0.5 mrad with 2 ms.
CONTACT = "0.002 1"
# Impedance of a contact. The default of 0.9 lets a sole under load creep.
IMPEDANCE = "0.95 0.99 0.0005"
# Iterations by which feet do not creep.
NO_SLIP = 10
# Time to settle before the plan, and to stand after it, s.
SETTLE, HOLD = 0.5, 1.0
# Steps from one look at the tilt to the next.
CHECK_EVERY = 20
# A robot whose root is this far from the plan (m), or tilted this far (rad), falls.
FALL_DISTANCE, FALL_TILT = 0.25, 0.7
# A cylinder whose axis rises less than this (sine) is a capsule, with a cap beyond each end: MuJoCo
# computes contacts of a box with a capsule in closed form. Of a box with a cylinder, both flat on
# each other, it finds normals that point along the ground: a sole whose edge is a millimetre beyond
# a bar's highest line is pushed off the bar.
LYING = 0.5
# Height of a sole, m. A sole is a mesh, although most are nearly boxes: of two boxes that lie on
# each other, MuJoCo finds four contacts in one step and one at a corner in the next, with normals
# along the ground. The forces jump, and a robot that stands still creeps and turns.
SOLE_HEIGHT = 0.02
# Triangles of world meshes are this thick, m.
SLAB = 0.03


class Unusable(Exception):
    """The plan cannot be replayed."""


def gains(limits):
    """Stiffness (N m/rad) and damping (N m s/rad) of drives with these effort limits (N m)."""
    return STIFFNESS * limits, DAMPING * STIFFNESS * limits


def numbers(values):
    return " ".join(f"{value:.12g}" for value in values)


def wxyz(quaternion):
    return [quaternion[3], *quaternion[:3]]


def rotation(quaternion_xyzw):
    x, y, z, w = np.asarray(quaternion_xyzw) / np.linalg.norm(quaternion_xyzw)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def rpy_matrix(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = [(math.cos(a), math.sin(a)) for a in (roll, pitch, yaw)]
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def quaternion_of(matrix):
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, matrix.flatten())
    return quaternion


def origin_of(element):
    origin = element.find("origin") if element is not None else None
    read = lambda name: [float(v) for v in (origin.get(name) or "0 0 0").split()]
    if origin is None:
        return np.zeros(3), np.eye(3)
    return np.array(read("xyz")), rpy_matrix(*read("rpy"))


class Robot:
    """The links and joints of a URDF, as MJCF."""

    def __init__(self, plan, folder, assets, vary):
        self.assets = assets
        self.block = plan["robot"]
        path = folder / self.block["urdf"]
        try:
            urdf = xml.parse(path).getroot()
        except (OSError, xml.ParseError) as error:
            raise Unusable(f"{path}: {error}") from error
        self.links = {link.get("name"): link for link in urdf.findall("link")}
        self.joints = urdf.findall("joint")
        self.vary = vary
        children = {joint.find("child").get("link") for joint in self.joints}
        self.root = next(name for name in self.links if name not in children)
        self.moving = set(plan["joint_names"])
        self.limits = {}
        scale = self.block.get("effort_scale", 1.0)
        for joint in self.joints:
            limit = joint.find("limit")
            # An effort of 0 is one that the URDF does not know.
            stated = float(limit.get("effort", 0)) if limit is not None else 0.0
            chosen = self.block.get("effort_limits", {}).get(joint.get("name"), stated)
            effort = min(stated, chosen) if stated > 0.0 else chosen
            self.limits[joint.get("name")] = scale * effort

    def body(self, parent, name, xyz, quaternion):
        body = xml.SubElement(parent, "body", name=name, pos=numbers(xyz), quat=numbers(quaternion))
        if name == self.root:
            xml.SubElement(body, "freejoint", name="root")
        self.add_inertia(body, self.links[name].find("inertial"))
        for side, foot in self.block["feet"].items():
            if foot["link"] == name:
                self.add_sole(body, side, foot)
        for joint in self.joints:
            if joint.find("parent").get("link") == name:
                self.add_joint(body, joint)

    def add_joint(self, body, joint):
        name, kind = joint.get("name"), joint.get("type")
        xyz, turn = origin_of(joint)
        axis = joint.find("axis")
        axis = [float(v) for v in axis.get("xyz").split()] if axis is not None else [1.0, 0.0, 0.0]
        moves = name in self.moving
        if kind != "fixed" and not moves:
            at = self.block.get("locked_joints", {}).get(name, 0.0)
            if kind == "prismatic":
                xyz = xyz + turn @ (at * np.array(axis))
            else:
                quaternion = np.zeros(4)
                mujoco.mju_axisAngle2Quat(quaternion, np.array(axis), at)
                turn = turn @ rotation([*quaternion[1:], quaternion[0]])
        child = joint.find("child").get("link")
        self.body(body, child, xyz, quaternion_of(turn))
        if moves:
            inner = body.findall("body")[-1]
            # The drives damp the speed at the end of a step. As inertia that is known when contact
            # forces are found; as damping of the joint it acts after them, and feet turn.
            _, damping = gains(self.limits[name])
            moved = xml.Element(
                "joint", name=name, axis=numbers(axis),
                type="slide" if kind == "prismatic" else "hinge",
                armature=f"{ARMATURE * self.limits[name] + STEP * damping:.9g}")
            inner.insert(0, moved)

    def add_inertia(self, body, inertial):
        if inertial is None or float(inertial.find("mass").get("value")) <= 0.0:
            return
        xyz, turn = origin_of(inertial)
        values = inertial.find("inertia")
        xx, xy, xz, yy, yz, zz = [
            float(values.get(name)) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
        factor = self.vary(0.95, 1.05)
        inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T * factor
        ordered = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        mass = factor * float(inertial.find("mass").get("value"))
        xml.SubElement(body, "inertial", pos=numbers(xyz), mass=f"{mass:.12g}",
                       fullinertia=numbers(ordered))

    def add_sole(self, body, side, foot):
        pose = foot["sole_pose"]
        placed = {"pos": numbers(pose["xyz"]), "quat": numbers(wxyz(pose["quat_xyzw"]))}
        corners = [[*corner, z] for z in (0.0, SOLE_HEIGHT) for corner in foot["polygon"]]
        name = f"{side}_sole"
        xml.SubElement(self.assets, "mesh", name=name, vertex=numbers(np.ravel(corners)))
        xml.SubElement(body, "geom", name=name, type="mesh", mesh=name, contype="1",
                       conaffinity="2", mass="0", **placed)
        xml.SubElement(body, "site", name=f"{side}_frame", **placed)


def triangles_of(path):
    """The triangles of an STL or OBJ file."""
    data = path.read_bytes()
    if path.suffix.lower() == ".obj":
        points, faces = [], []
        for words in (line.split() for line in data.decode(errors="replace").splitlines()):
            if words[:1] == ["v"]:
                points.append([float(v) for v in words[1:4]])
            elif words[:1] == ["f"]:
                index = [int(word.split("/")[0]) for word in words[1:]]
                index = [i - 1 if i > 0 else len(points) + i for i in index]
                faces += [[index[0], index[k], index[k + 1]] for k in range(1, len(index) - 1)]
        return np.array(points)[np.array(faces)]
    if path.suffix.lower() != ".stl":
        raise Unusable(f"{path}: only STL and OBJ meshes can be replayed")
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else 0
    if len(data) == 84 + 50 * count:
        rows = np.frombuffer(data, dtype=np.dtype("3<f4,(3,3)<f4,<u2"), offset=84)
        return np.array([row[1] for row in rows], dtype=float)
    words = data.decode(errors="replace").split()
    at = [i for i, word in enumerate(words) if word == "vertex"]
    return np.array([[float(v) for v in words[i + 1:i + 4]] for i in at]).reshape(-1, 3, 3)


def touching(friction):
    """The attributes of a geom that touches others."""
    return {"friction": f"{friction:.6g} 0.005 0.0001", "solref": CONTACT, "solimp": IMPEDANCE}


def add_world(top, plan, folder, friction):
    assets, world = top.find("asset"), top.find("worldbody")
    common = {"contype": "2", "conaffinity": "1", **touching(friction)}

    def hull(points, placed):
        name = f"hull{len(assets)}"
        xml.SubElement(assets, "mesh", name=name, vertex=numbers(np.asarray(points).flatten()))
        # MuJoCo moves a mesh to its centre, and its geom with it.
        xml.SubElement(world, "geom", type="mesh", mesh=name, **placed, **common)

    for entry in plan["scene"]["shapes"]:
        shape, pose = entry["shape"], entry["pose"]
        placed = {"pos": numbers(pose["xyz"]), "quat": numbers(wxyz(pose["quat_xyzw"]))}
        kind = shape["type"]
        sizes = {
            "box": lambda: shape["half_extents"],
            "sphere": lambda: [shape["radius"]],
            "cylinder": lambda: [shape["radius"], 0.5 * shape["length"]],
            "capsule": lambda: [shape["radius"], 0.5 * shape["length"]],
        }
        if kind in sizes:
            lies = kind == "cylinder" and abs(rotation(pose["quat_xyzw"])[2, 2]) < LYING
            kind = "capsule" if lies else kind
            xml.SubElement(world, "geom", type=kind, size=numbers(sizes[kind]()), **placed, **common)
        elif kind == "convex" and "points" in shape:
            hull(shape["points"], placed)
        else:
            scale = np.ones(3) * np.array(shape.get("scale", 1.0))
            triangles = triangles_of(folder / shape["path"]) * scale
            if kind == "convex":
                hull(triangles.reshape(-1, 3), placed)
                continue
            up = rotation(pose["quat_xyzw"])[2]
            for triangle in triangles:
                normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
                length = np.linalg.norm(normal)
                # No sole stands on a face that looks down, and its slab would reach through the
                # top of a body thinner than that.
                if length > 1e-9 and up @ normal > -1e-3 * length:
                    hull([*triangle, *(triangle - SLAB * normal / length)], placed)


class Motion:
    """The joints and the root at any times, as the plan format says."""

    def __init__(self, plan):
        waypoints = plan["waypoints"]
        self.times = np.array([waypoint["t"] for waypoint in waypoints])
        read = lambda key: np.array([waypoint[key] for waypoint in waypoints], dtype=float)
        self.q, self.root, self.turn = read("q"), read("root_xyz"), read("root_quat_xyzw")
        moves = bool(waypoints[0].get("velocity"))
        self.rates = [read("velocity")[:, 6:], read("acceleration")[:, 6:]] if moves else None
        self.torque = read("torque") if waypoints[0].get("torque") else np.zeros_like(self.q)

    def sample(self, times):
        """Joint positions, speeds and torques, and the root's place and rotation, a row a time."""
        times = np.clip(times, self.times[0], self.times[-1])
        last = np.clip(np.searchsorted(self.times, times, "right"), 1, len(self.times) - 1)
        first = last - 1
        span = (self.times[last] - self.times[first])[:, None]
        s = (times - self.times[first])[:, None] / span
        mix = lambda rows: (1 - s) * rows[first] + s * rows[last]
        sign = np.sign(np.sum(self.turn[first] * self.turn[last], axis=1))[:, None]
        turn = (1 - s) * self.turn[first] + s * sign * self.turn[last]
        if self.rates is not None:
            q, speed = self.curve(first, last, s, span)
        else:
            moves = ((self.times[0] < times) & (times < self.times[-1]))[:, None]
            q, speed = mix(self.q), moves * (self.q[last] - self.q[first]) / span
        return q, speed, mix(self.torque), mix(self.root), turn

    def curve(self, first, last, s, span):
        """The polynomials of degree 5 and their derivatives, from Bernstein coefficients."""
        p0, p1 = self.q[first], self.q[last]
        v0, v1 = span * self.rates[0][first], span * self.rates[0][last]
        a0, a1 = span**2 * self.rates[1][first], span**2 * self.rates[1][last]
        points = [p0, p0 + v0 / 5, p0 + 2 * v0 / 5 + a0 / 20,
                  p1 - 2 * v1 / 5 + a1 / 20, p1 - v1 / 5, p1]
        basis = lambda n: [math.comb(n, k) * s**k * (1 - s)**(n - k) for k in range(n + 1)]
        q = sum(b * point for b, point in zip(basis(5), points))
        slopes = [5 * (b - a) for a, b in zip(points, points[1:])]
        return q, sum(b * slope for b, slope in zip(basis(4), slopes)) / span


@dataclasses.dataclass
class Outcome:
    """How a replay ends."""
    stands: bool
    # Time since the plan's beginning, s.
    seconds: float
    # Largest and last distance of the root from the plan, m.
    root: float
    root_at_end: float
    # How far each foot that landed is from its place relative to the other foot, m.
    landings: list


class Replay:
    def __init__(self, plan, folder, seed):
        draw = random.Random(seed)
        vary = (lambda low, high: draw.uniform(low, high)) if seed is not None else (lambda *_: 1.0)
        self.plan, self.motion = plan, Motion(plan)
        top = xml.Element("mujoco")
        robot = Robot(plan, folder, xml.SubElement(top, "asset"), vary)
        xml.SubElement(top, "compiler", angle="radian", balanceinertia="true",
                       boundmass="1e-5", boundinertia="1e-7", autolimits="true")
        xml.SubElement(top, "option", timestep=str(STEP), integrator="implicitfast",
                       cone="elliptic", impratio="10", noslip_iterations=str(NO_SLIP))
        world = xml.SubElement(top, "worldbody")
        first = plan["waypoints"][0]
        robot.body(world, robot.root, first["root_xyz"], wxyz(first["root_quat_xyzw"]))
        friction = plan["scene"]["mu"] * vary(0.8, 1.0)
        for geom in world.iter("geom"):
            for key, value in touching(friction).items():
                geom.set(key, value)
        add_world(top, plan, folder, friction)
        self.delay = draw.uniform(0.0, 0.004) if seed is not None else 0.0
        try:
            self.model = mujoco.MjModel.from_xml_string(xml.tostring(top, "unicode"))
        except ValueError as error:
            raise Unusable(str(error)) from error
        self.data = mujoco.MjData(self.model)
        ids = [self.model.joint(name).id for name in plan["joint_names"]]
        self.places, self.freedoms = self.model.jnt_qposadr[ids], self.model.jnt_dofadr[ids]
        self.limits = np.array([robot.limits[name] for name in plan["joint_names"]])
        self.gains = gains(self.limits)
        self.data.qpos[self.places] = plan["waypoints"][0]["q"]
        mujoco.mj_forward(self.model, self.data)

    def run(self):
        """Replays the plan; it ends where the robot falls."""
        begin, end = self.motion.times[0], self.motion.times[-1]
        times = np.arange(begin - SETTLE, end + HOLD, STEP) + STEP
        # The drives damp towards the speed at the end of the step.
        wanted = self.motion.sample(times - self.delay)
        *_, roots, turns = self.motion.sample(times)
        landings, outcome = self.landings(), Outcome(True, end - begin, 0.0, 0.0, [])
        for row, time in enumerate(times):
            self.step(*(values[row] for values in wanted[:3]))
            error = float(np.linalg.norm(self.data.qpos[:3] - roots[row]))
            outcome.root, outcome.root_at_end = max(outcome.root, error), error
            if row % CHECK_EVERY == 0:
                planned = rotation(turns[row])[:, 2]
                up = planned @ rotation([*self.data.qpos[4:7], self.data.qpos[3]])[:, 2]
                if error > FALL_DISTANCE or not up > math.cos(FALL_TILT):
                    return dataclasses.replace(outcome, stands=False, seconds=time - begin)
            while landings and landings[0][0] <= time:
                outcome.landings.append(self.landing_error(landings.pop(0)[1]))
        return outcome

    def step(self, q, speed, torque):
        stiffness, damping = self.gains
        now = self.data.qvel[self.freedoms]
        wanted = torque + stiffness * (q - self.data.qpos[self.places]) + damping * (speed - now)
        self.data.qfrc_applied[self.freedoms] = np.clip(wanted, -self.limits, self.limits)
        mujoco.mj_step(self.model, self.data)

    def landings(self):
        """The middle of each phase on both feet after one on one foot, with its soles."""
        phases, found = self.plan["phases"], []
        for before, phase in zip(phases, phases[1:]):
            if before["mode"] != "double" and phase["mode"] == "double":
                times = [self.motion.times[phase[key]] for key in ("first", "last")]
                soles = {c["foot"]: c["sole_pose"] for c in phase["contacts"]}
                moved = "left" if before["mode"] == "right" else "right"
                found.append((sum(times) / 2, (moved, soles)))
        return found

    def landing_error(self, landing):
        """How far the foot that landed is from its place relative to the other foot, m."""
        moved, soles = landing
        other = "right" if moved == "left" else "left"
        place = lambda side: np.array(soles[side]["xyz"])
        planned = rotation(soles[other]["quat_xyzw"]).T @ (place(moved) - place(other))
        sites = {side: self.data.site(f"{side}_frame") for side in soles}
        turn = sites[other].xmat.reshape(3, 3)
        actual = turn.T @ (sites[moved].xpos - sites[other].xpos)
        return float(np.linalg.norm(actual - planned))


def replay(path, seed=None):
    """Replays the plan of a file.

    Raises Unusable, OSError, ValueError or KeyError where it cannot be replayed.
    """
    return Replay(json.loads(path.read_text()), path.parent, seed).run()


def report(path, seed):
    try:
        outcome = replay(path, seed)
    except (OSError, ValueError, KeyError, Unusable) as error:
        print(f"{path}: cannot be replayed: {error}", file=sys.stderr)
        return 2
    landings = outcome.landings
    landing = f"{1e3 * max(landings):.1f}" if landings else "-"
    print(f"{path.name}: {'stands' if outcome.stands else 'FALLS'} after {outcome.seconds:.1f} s; "
          f"root error {1e3 * outcome.root:.0f} mm at most, {1e3 * outcome.root_at_end:.0f} mm at "
          f"the end; {len(landings)} landings, at most {landing} mm off", flush=True)
    return 0 if outcome.stands else 1


def main():
    parser = argparse.ArgumentParser(description="Replays exported plans in MuJoCo.")
    parser.add_argument("plans", nargs="+", type=Path, metavar="PLAN.json")
    parser.add_argument("--disturb", type=int, metavar="SEED",
                        help="vary masses, friction and delay by this seed")
    arguments = parser.parse_args()
    sys.exit(max(report(path, arguments.disturb) for path in arguments.plans))


if __name__ == "__main__":
    main()
