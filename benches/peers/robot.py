"""A robot and its scene for Pinocchio and Coal, built from Surefoot's description of the same problem."""

import os
import xml.etree.ElementTree as xml

import coal
import numpy as np
import pinocchio as pin


class Robot:
    """A free-floating robot in a scene, with Surefoot's joint order and pairs of links."""

    def __init__(self, problem, scene=()):
        urdf = problem["urdf"]
        tree = xml.parse(urdf).getroot()
        # Pinocchio's own reader does not know capsules: shapes are added by hand.
        shapes = [(link.get("name"), element) for link in tree.iter("link") for element in link.findall("collision")]
        for link in tree.iter("link"):
            for element in link.findall("collision") + link.findall("visual"):
                link.remove(element)
        self.model = pin.buildModelFromXML(xml.tostring(tree, encoding="unicode"), pin.JointModelFreeFlyer())
        self.geometry = pin.GeometryModel()
        for index, (link, element) in enumerate(shapes):
            self._add_link_shape(link, index, element, os.path.dirname(urdf))
        self.feet = [self.model.getFrameId(name) for name in problem["foot_links"]]
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in problem["joint_names"]]
        self.q_places = [joint.idx_q for joint in self.joints]
        self._pair(problem["allowed_pairs"], scene)
        self.data = self.model.createData()
        self.geometry_data = self.geometry.createData()

    def _add_link_shape(self, link, index, element, folder):
        frame = self.model.getFrameId(link)
        origin = element.find("origin")
        numbers = lambda name: [float(x) for x in (origin.get(name) if origin is not None and origin.get(name) else "0 0 0").split()]
        link_from_shape = pin.SE3(pin.rpy.rpyToMatrix(*numbers("rpy")), np.array(numbers("xyz")))
        parent = self.model.frames[frame]
        pose = parent.placement * link_from_shape
        shape = urdf_solid(next(iter(element.find("geometry"))), folder)
        self.geometry.addGeometryObject(pin.GeometryObject(f"{link} {index}", parent.parentJoint, frame, pose, shape))

    def _link(self, obj):
        return self.model.frames[obj.parentFrame].name

    def _pair(self, allowed, scene):
        robot = list(range(self.geometry.ngeoms))
        names = [self._link(obj) for obj in self.geometry.geometryObjects]
        allowed = {frozenset(pair) for pair in allowed}
        for a in robot:
            for b in robot[:a]:
                if names[a] != names[b] and frozenset((names[a], names[b])) not in allowed:
                    self.geometry.addCollisionPair(pin.CollisionPair(b, a))
        for shape in scene:
            pose = pin.XYZQUATToSE3(np.array(shape["pose"]["xyz"] + shape["pose"]["quat_xyzw"], dtype=float))
            obj = pin.GeometryObject(f"scene {shape['name']}", 0, pose, solid(shape["shape"]))
            index = self.geometry.addGeometryObject(obj)
            for a in robot:
                self.geometry.addCollisionPair(pin.CollisionPair(a, index))

    def q(self, configuration, lift=0.0):
        """Pinocchio's configuration of Surefoot's; all of it is raised by `lift` (m)."""
        q = pin.neutral(self.model)
        q[:3] = configuration["root_xyz"]
        q[2] += lift
        q[3:7] = configuration["root_quat_xyzw"]
        q[self.q_places] = configuration["q"]
        return q

    def collides(self, q):
        return pin.computeCollisions(self.model, self.data, self.geometry, self.geometry_data, q, True)


def urdf_solid(element, folder):
    """Coal's geometry of a URDF's; a mesh becomes its convex hull, as in Surefoot."""
    numbers = lambda name, standard="": [float(x) for x in element.get(name, standard).split()]
    if element.tag == "box":
        return coal.Box(*numbers("size"))
    if element.tag == "sphere":
        return coal.Sphere(*numbers("radius"))
    if element.tag in ("cylinder", "capsule"):
        return {"cylinder": coal.Cylinder, "capsule": coal.Capsule}[element.tag](*numbers("radius"), *numbers("length"))
    mesh = coal.MeshLoader().load(os.path.join(folder, element.get("filename").split("//")[-1]), np.array(numbers("scale", "1 1 1")))
    mesh.buildConvexRepresentation(False)
    return mesh.convex


def solid(shape):
    """Coal's geometry of a shape of a plan file."""
    kind = shape["type"]
    if kind == "box":
        return coal.Box(*(2.0 * half for half in shape["half_extents"]))
    if kind == "sphere":
        return coal.Sphere(shape["radius"])
    if kind == "cylinder":
        return coal.Cylinder(shape["radius"], shape["length"])
    if kind == "capsule":
        return coal.Capsule(shape["radius"], shape["length"])
    raise SystemExit(f"no peer geometry for a {kind}")
