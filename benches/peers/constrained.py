"""The peer of single-mode planning: OMPL's RRTConnect on constrained state spaces.

Constraints by Pinocchio, collisions by Coal.

The problem is Surefoot's weight shift in double support: from one configuration to another, both soles fixed, the centre of mass inside the
support polygon, joints within limits, nothing colliding. A state is the root's position and rotation vector, then the joints.
"""

import time

import numpy as np
import pinocchio as pin
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

TOLERANCE = 1e-3


class BothSolesStand(ob.Constraint):
    """Both soles are where they stand: twelve equations."""

    def __init__(self, robot, soles):
        super().__init__(len(robot.q_places) + 6, 12)
        self.robot, self.soles = robot, soles

    def configuration(self, x):
        q = pin.neutral(self.robot.model)
        q[:3] = x[:3]
        q[3:7] = pin.Quaternion(pin.exp3(np.asarray(x[3:6]))).coeffs()
        q[self.robot.q_places] = x[6:]
        return q

    def function(self, x, out):
        robot = self.robot
        pin.framesForwardKinematics(robot.model, robot.data, self.configuration(x))
        for index, (foot, sole) in enumerate(zip(robot.feet, self.soles)):
            out[6 * index : 6 * index + 6] = pin.log6(sole.actInv(robot.data.oMf[foot])).vector

    def jacobian(self, x, out):
        robot = self.robot
        model, data, q = robot.model, robot.data, self.configuration(x)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        # The root's velocity is in its own frame in Pinocchio; the state's is the position's and the rotation vector's.
        rotation = pin.exp3(np.asarray(x[3:6]))
        columns = [joint.idx_v for joint in robot.joints]
        for index, (foot, sole) in enumerate(zip(robot.feet, self.soles)):
            error = sole.actInv(data.oMf[foot])
            local = pin.Jlog6(error) @ pin.getFrameJacobian(model, data, foot, pin.LOCAL)
            rows = slice(6 * index, 6 * index + 6)
            out[rows, :3] = local[:, :3] @ rotation.T
            out[rows, 3:6] = local[:, 3:6] @ pin.Jexp3(np.asarray(x[3:6]))
            out[rows, 6:] = local[:, columns]


def state_of(configuration):
    """Surefoot's configuration as a state."""
    rotation = pin.log3(pin.Quaternion(np.array(configuration["root_quat_xyzw"])).toRotationMatrix())
    return np.concatenate([configuration["root_xyz"], rotation, configuration["q"]])


def depth(region, point):
    """How deep a point lies inside a counter-clockwise polygon, negative outside (m)."""
    edges = np.roll(region, -1, axis=0) - region
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1, keepdims=True)
    return np.min(np.einsum("ij,ij->i", inward, point - region))


class SingleModeProblem:
    def __init__(self, robot, shift):
        self.robot, self.margin = robot, shift["com_margin"]
        self.region = np.array(shift["region"])
        self.ends = [state_of(shift[end]) for end in ("from", "to")]
        # Raised as a whole, so that touching soles are no collision.
        for end in self.ends:
            end[2] += 0.0015
        pin.framesForwardKinematics(robot.model, robot.data, robot.q(shift["from"], 0.0015))
        soles = [robot.data.oMf[foot].copy() for foot in robot.feet]
        self.constraint = BothSolesStand(robot, soles)
        low, high = np.minimum(*self.ends)[:6] - 0.3, np.maximum(*self.ends)[:6] + 0.3
        limits = [getattr(robot.model, name)[robot.q_places] for name in ("lowerPositionLimit", "upperPositionLimit")]
        self.low, self.high = np.concatenate([low, limits[0]]), np.concatenate([high, limits[1]])

    def is_valid(self, state):
        x = np.array([state[index] for index in range(len(self.low))])
        q = self.constraint.configuration(x)
        com = pin.centerOfMass(self.robot.model, self.robot.data, q)[:2]
        return depth(self.region, com) >= 0.0 and not self.robot.collides(q)

    def solve(self, space_type, seconds_max):
        """Time to a path (s), or None, and the number of its states."""
        dimension = len(self.low)
        ambient = ob.RealVectorStateSpace(dimension)
        bounds = ob.RealVectorBounds(dimension)
        for index in range(dimension):
            bounds.setLow(index, float(self.low[index]))
            bounds.setHigh(index, float(self.high[index]))
        ambient.setBounds(bounds)
        self.constraint.setTolerance(TOLERANCE)
        space = space_type(ambient, self.constraint)
        information = ob.ConstrainedSpaceInformation(space)
        setup = og.SimpleSetup(information)
        setup.setStateValidityChecker(self.is_valid)
        states = []
        for end in self.ends:
            state = space.allocState()
            state.copy([float(value) for value in end])
            states.append(state)
        if hasattr(space, "anchorChart"):
            for state in states:
                space.anchorChart(state)
        setup.setStartAndGoalStates(states[0], states[1], 0.01)
        setup.setPlanner(og.RRTConnect(information))
        setup.setup()
        begin = time.perf_counter()
        solved = setup.solve(seconds_max)
        seconds = time.perf_counter() - begin
        exact = bool(solved) and setup.haveExactSolutionPath()
        return (seconds, setup.getSolutionPath().getStateCount()) if exact else (None, 0)


def times(robot, shift, space_name, trials, seconds_max):
    """The times to a path of some trials, None where there was none in time."""
    ou.setLogLevel(ou.LogLevel.LOG_ERROR)
    problem = SingleModeProblem(robot, shift)
    return [problem.solve(getattr(ob, space_name), seconds_max)[0] for _ in range(trials)]
