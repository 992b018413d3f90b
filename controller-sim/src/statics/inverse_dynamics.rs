//! The wrench that a moving robot demands of its contacts, and the torques of its joints
//! (Newton-Euler, link by link in the world frame).

use glam::{DMat3, DVec3};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::{Attachment, JointKind, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

use crate::kinematics::forward::{Posture, along_axis};
use crate::statics::equilibrium::{Generator, MinimaxEffort, dot, wrench_balance};
use crate::statics::simplex::Row;

/// A force (N) and its torque about the world's origin (N m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    /// The force.
    pub force: DVec3,
    /// The torque about the origin.
    pub torque: DVec3,
}

impl Wrench {
    const ZERO: Self = Self { force: DVec3::ZERO, torque: DVec3::ZERO };

    /// The point at this height at which the force would act without a torque about a horizontal
    /// axis: the zero-moment point. Not a number where nothing presses down.
    pub fn zero_moment_point(&self, height: f64) -> DVec3 {
        let torque = self.torque - (height * DVec3::Z).cross(self.force);
        let press = if self.force.z > 0.0 { self.force.z } else { f64::NAN };
        DVec3::new(-torque.y / press, torque.x / press, height)
    }

    /// What it exerts on a joint, N m or N.
    fn on_joint(&self, model: &RobotModel, posture: &Posture, joint: usize) -> f64 {
        let (axis, origin) = posture.joint_axis(model, joint);
        match model.joints[joint].kind {
            JointKind::Revolute => axis.dot(self.torque - origin.cross(self.force)),
            JointKind::Prismatic => axis.dot(self.force),
        }
    }
}

/// How a link moves, in the world frame.
#[derive(Debug, Clone, Copy)]
struct LinkMotion {
    omega: DVec3,
    alpha: DVec3,
    /// Acceleration of the link frame's origin.
    acceleration: DVec3,
}

/// The inverse dynamics of one instant.
#[derive(Debug, Clone)]
pub struct InverseDynamics {
    /// The wrench that all contacts together exert on the robot.
    pub contacts: Wrench,
    /// The joint torques (N m) or forces (N) if nothing but the root were held.
    free: Vec<f64>,
}

impl InverseDynamics {
    /// For a robot in `posture` with the velocity and acceleration of `waypoint`. Joints of the
    /// model beyond the waypoint's are locked.
    pub fn new(model: &RobotModel, posture: &Posture, waypoint: &Waypoint) -> Self {
        let motions = link_motions(model, posture, waypoint);
        let mut wrenches: Vec<Wrench> = motions
            .iter()
            .enumerate()
            .map(|(link, motion)| inertial_wrench(model, posture, link, motion))
            .collect();
        for index in (1..wrenches.len()).rev() {
            if let Some(attachment) = &model.links[index].parent {
                let Wrench { force, torque } = wrenches[index];
                wrenches[attachment.parent].force += force;
                wrenches[attachment.parent].torque += torque;
            }
        }
        let free = (0..model.joints.len())
            .map(|joint| wrenches[model.joints[joint].child].on_joint(model, posture, joint));
        Self { contacts: wrenches.first().copied().unwrap_or(Wrench::ZERO), free: free.collect() }
    }

    /// The joint torques that remain beside these, N m or N.
    pub fn less(mut self, torques: &[f64]) -> Self {
        self.free.iter_mut().zip(torques).for_each(|(free, torque)| *free -= torque);
        self
    }

    /// The joint torques of a robot on one foot, which exerts the whole contact wrench.
    pub fn torques_on(&self, model: &RobotModel, posture: &Posture, limb: usize) -> Vec<f64> {
        let mut torques = self.free.clone();
        for joint in model.chain(model.feet[limb].link) {
            torques[joint] -= self.contacts.on_joint(model, posture, joint);
        }
        torques
    }

    /// The joint torques under the contact forces that minimise the largest share of an effort
    /// limit; nothing where no forces within the friction pyramids of `generators` (in units of the
    /// robot's weight) exert the contact wrench.
    pub fn torques(
        &self,
        model: &RobotModel,
        posture: &Posture,
        generators: &[Generator],
        share_max: f64,
    ) -> Option<Vec<f64>> {
        let weight = model.mass() * GRAVITY;
        let loaded = loaded_joints(model, posture, generators);
        let share = |(joint, taken): &(usize, Vec<f64>)| {
            let effort = model.joints[*joint].effort;
            let row: Vec<f64> = taken.iter().map(|value| -weight * value / effort).collect();
            (row, self.free[*joint] / effort)
        };
        let balance = self.balance(model, generators);
        let program = MinimaxEffort::with_balance(balance, loaded.iter().map(share).collect());
        let torques = |forces: Vec<f64>| self.unloaded(&loaded, weight, &forces);
        let fits = |torques: &Vec<f64>| {
            let joints = torques.iter().zip(&model.joints);
            joints.into_iter().all(|(torque, joint)| torque.abs() <= share_max * joint.effort)
        };
        let quick = program.by_simplex().map(torques).filter(fits);
        quick.or_else(|| program.by_interior_point().map(torques))
    }

    /// The balance rows of contact forces, in units of the robot's weight, that move the robot so.
    pub fn balance(&self, model: &RobotModel, generators: &[Generator]) -> Vec<Row> {
        let weight = model.mass() * GRAVITY;
        let Wrench { force, torque } = self.contacts;
        wrench_balance(generators, force / weight, torque / weight)
    }

    /// The joint torques under contact forces: a share of the weight for each generator, or no
    /// forces at all.
    pub fn torques_under(
        &self,
        model: &RobotModel,
        posture: &Posture,
        (generators, forces): (&[Generator], &[f64]),
    ) -> Vec<f64> {
        let weight = model.mass() * GRAVITY;
        self.unloaded(&loaded_joints(model, posture, generators), weight, forces)
    }

    fn unloaded(&self, loaded: &[LoadedJoint], weight: f64, forces: &[f64]) -> Vec<f64> {
        let mut torques = self.free.clone();
        for (joint, taken) in loaded {
            torques[*joint] -= weight * dot(taken, forces);
        }
        torques
    }
}

/// A joint, and by how much one unit of each generator unloads it.
type LoadedJoint = (usize, Vec<f64>);

/// The joints that some generator unloads.
fn loaded_joints(
    model: &RobotModel,
    posture: &Posture,
    generators: &[Generator],
) -> Vec<LoadedJoint> {
    (0..model.joints.len())
        .map(|joint| (joint, taken_by(model, posture, generators, joint)))
        .filter(|(_, taken)| taken.iter().any(|share| *share != 0.0))
        .collect()
}

/// By how much one unit of each generator unloads a joint.
fn taken_by(
    model: &RobotModel,
    posture: &Posture,
    generators: &[Generator],
    joint: usize,
) -> Vec<f64> {
    let (kind, axis) = (model.joints[joint].kind, posture.joint_axis(model, joint));
    let carries: Vec<bool> =
        model.feet.iter().map(|foot| model.chain(foot.link).contains(&joint)).collect();
    let taken = |generator: &Generator| {
        if carries[generator.limb] {
            along_axis(kind, axis, generator.point, generator.force)
        } else {
            0.0
        }
    };
    generators.iter().map(taken).collect()
}

fn link_motions(model: &RobotModel, posture: &Posture, waypoint: &Waypoint) -> Vec<LinkMotion> {
    let (root_velocity, root_acceleration) = (waypoint.root_velocity, waypoint.root_acceleration);
    let mut motions: Vec<LinkMotion> = Vec::with_capacity(model.links.len());
    for (index, link) in model.links.iter().enumerate() {
        motions.push(match &link.parent {
            None => LinkMotion {
                omega: DVec3::new(root_velocity[3], root_velocity[4], root_velocity[5]),
                alpha: DVec3::new(root_acceleration[3], root_acceleration[4], root_acceleration[5]),
                acceleration: DVec3::new(
                    root_acceleration[0],
                    root_acceleration[1],
                    root_acceleration[2],
                ),
            },
            Some(attachment) => {
                let carried = carried_along(posture, attachment, &motions, index);
                add_joint(model, posture, attachment, carried, waypoint)
            }
        });
    }
    motions
}

/// The motion of a link if its joint does not move.
fn carried_along(
    posture: &Posture,
    attachment: &Attachment,
    motions: &[LinkMotion],
    link: usize,
) -> LinkMotion {
    let LinkMotion { omega, alpha, acceleration } = motions[attachment.parent];
    let [origin, parent] =
        [link, attachment.parent].map(|link| posture.world_from_link[link].translation);
    let arm = origin - parent;
    let acceleration = acceleration + alpha.cross(arm) + omega.cross(omega.cross(arm));
    LinkMotion { omega, alpha, acceleration }
}

fn add_joint(
    model: &RobotModel,
    posture: &Posture,
    attachment: &Attachment,
    carried: LinkMotion,
    waypoint: &Waypoint,
) -> LinkMotion {
    let Some(joint) = attachment.joint else { return carried };
    let rate = |rates: &[f64]| rates.get(joint).copied().unwrap_or(0.0);
    let (axis, _) = posture.joint_axis(model, joint);
    let velocity = rate(&waypoint.joint_velocity) * axis;
    let acceleration = rate(&waypoint.joint_acceleration) * axis;
    let LinkMotion { omega, alpha, acceleration: origin } = carried;
    match model.joints[joint].kind {
        JointKind::Revolute => LinkMotion {
            omega: omega + velocity,
            alpha: alpha + acceleration + omega.cross(velocity),
            acceleration: origin,
        },
        JointKind::Prismatic => LinkMotion {
            omega,
            alpha,
            acceleration: origin + acceleration + 2.0 * omega.cross(velocity),
        },
    }
}

/// The wrench that moves a link and carries its weight.
fn inertial_wrench(
    model: &RobotModel,
    posture: &Posture,
    link: usize,
    motion: &LinkMotion,
) -> Wrench {
    let (body, pose) = (&model.links[link], &posture.world_from_link[link]);
    let arm = pose.rotation * body.com;
    let LinkMotion { omega, alpha, acceleration } = *motion;
    let of_centre = acceleration + alpha.cross(arm) + omega.cross(omega.cross(arm));
    let force = body.mass * (of_centre + GRAVITY * DVec3::Z);
    let rotation = DMat3::from_quat(pose.rotation);
    let inertia = rotation * body.inertia * rotation.transpose();
    let spin = inertia * alpha + omega.cross(inertia * omega);
    Wrench { force, torque: (pose.translation + arm).cross(force) + spin }
}

#[cfg(test)]
mod tests;
