"""The peer of posture sampling: random root and free joints.

Legs by damped least squares with Pinocchio, collisions by Coal.

The draws are those of Surefoot's uniform transition samples: root turned up to 0.6 rad about the vertical, 0.25 about the
forward and 0.3 about the sideways axis, free joints up to 0.5 rad from standing, the centre of mass over one foot.
"""

import time

import numpy as np
import pinocchio as pin

ITERATIONS_MAX = 30
TOLERANCE = 1e-4


class StanceSampler:
    def __init__(self, robot, problem, seed=1):
        self.robot, self.random = robot, np.random.default_rng(seed)
        self.standing = robot.q(problem["standing"], lift=0.0015)
        model, data = robot.model, robot.data
        pin.framesForwardKinematics(model, data, self.standing)
        self.soles = [data.oMf[foot].copy() for foot in robot.feet]
        legs = [self._leg(foot) for foot in robot.feet]
        self.legs = sorted(set(legs[0] + legs[1]))
        self.free = [joint.idx_q for joint in robot.joints if joint.idx_v not in self.legs]
        self.columns = [0, 1, 2] + self.legs

    def _leg(self, foot):
        model = self.robot.model
        joint, columns = model.frames[foot].parentJoint, []
        while joint > 1:
            columns.append(model.joints[joint].idx_v)
            joint = model.parents[joint]
        return columns

    def sample(self):
        """A collision-free stance with the centre of mass over the first foot, or None."""
        model, data, random = self.robot.model, self.robot.data, self.random
        q = self.standing.copy()
        rpy = random.uniform([-0.25, -0.3, -0.6], [0.25, 0.3, 0.6])
        q[3:7] = pin.Quaternion(pin.rpy.rpyToMatrix(*rpy)).coeffs()
        q[2] -= random.uniform(0.0, 0.08)
        q[self.free] += random.uniform(-0.5, 0.5, len(self.free))
        q[7:] = np.clip(q[7:], model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
        com = self.soles[0].translation[:2] + random.uniform(-0.02, 0.02, 2)
        for _ in range(ITERATIONS_MAX):
            # One call fills poses and Jacobians of joints, frames and centre of mass.
            pin.jacobianCenterOfMass(model, data, q)
            pin.updateFramePlacements(model, data)
            errors, rows = [], []
            for foot, sole in zip(self.robot.feet, self.soles):
                error = pin.log6(data.oMf[foot].actInv(sole))
                errors.append(error.vector)
                rows.append(pin.getFrameJacobian(model, data, foot, pin.LOCAL))
            errors.append(com - data.com[0][:2])
            error = np.concatenate(errors)
            if np.abs(error).max() < TOLERANCE:
                return q if self._holds(q) else None
            jacobian = np.vstack(rows + [data.Jcom[:2]])[:, self.columns]
            step = np.zeros(model.nv)
            step[self.columns] = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-8 * np.eye(len(error)), error)
            q = pin.integrate(model, q, step)
        return None

    def _holds(self, q):
        model = self.robot.model
        inside = np.all(q[7:] >= model.lowerPositionLimit[7:]) and np.all(q[7:] <= model.upperPositionLimit[7:])
        return inside and not self.robot.collides(q)


def per_second(sampler, seconds):
    """Good stances per second, and how many of the attempts were good."""
    begin, good, tried = time.perf_counter(), 0, 0
    while time.perf_counter() - begin < seconds:
        good += sampler.sample() is not None
        tried += 1
    return good / (time.perf_counter() - begin), good / tried
