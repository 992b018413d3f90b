//! Link poses, centre of mass and gravity torques, computed from the definitions.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_about};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::{JointKind, LimbIndex, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

/// A whole-body configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// The root link's pose.
    pub world_from_root: Pose,
    /// One position per moving joint, rad or m.
    pub q: Vec<f64>,
}

impl Configuration {
    /// The configuration of a waypoint for a robot with `joints` moving joints.
    pub fn of_waypoint(waypoint: &Waypoint, joints: usize) -> Self {
        let pose = waypoint.world_from_root();
        Self {
            world_from_root: Pose::from_parts(pose.translation, pose.rotation.normalize()),
            q: waypoint.q[..joints].to_vec(),
        }
    }

    /// The configuration of a waypoint that moves the first `joints` joints; the others of the model
    /// are locked where they are when it stands.
    pub fn of_unlocked(model: &RobotModel, waypoint: &Waypoint, joints: usize) -> Self {
        let mut configuration = Self::of_waypoint(waypoint, joints);
        configuration.q.extend_from_slice(&model.standing_q[joints..]);
        configuration
    }

    /// The configuration a fraction `t` of the way to `end`, as the plan format defines motion
    /// between waypoints.
    pub fn towards(&self, end: &Self, t: f64) -> Self {
        Self {
            world_from_root: interpolate(&self.world_from_root, &end.world_from_root, t),
            q: self.q.iter().zip(&end.q).map(|(a, b)| a + t * (b - a)).collect(),
        }
    }
}

/// A configuration with the pose of every link.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// One pose per link of the model.
    pub world_from_link: Vec<Pose>,
}

impl Posture {
    /// Forward kinematics: each link's pose is its parent's, times the joint frame, times the
    /// joint's motion.
    pub fn new(model: &RobotModel, configuration: &Configuration) -> Self {
        let mut world_from_link: Vec<Pose> = Vec::with_capacity(model.links.len());
        for link in &model.links {
            world_from_link.push(match &link.parent {
                None => configuration.world_from_root,
                Some(attachment) => {
                    let world_from_joint =
                        world_from_link[attachment.parent] * attachment.parent_from_joint;
                    attachment.joint.map_or(world_from_joint, |joint| {
                        let joint_model = &model.joints[joint];
                        world_from_joint
                            * joint_motion(
                                joint_model.kind,
                                joint_model.axis,
                                configuration.q[joint],
                            )
                    })
                }
            });
        }
        Self { world_from_link }
    }

    /// The sole frame of a foot.
    pub fn world_from_sole(&self, model: &RobotModel, limb: LimbIndex) -> Pose {
        let foot = &model.feet[limb];
        self.world_from_link[foot.link] * foot.link_from_sole
    }

    /// The centre of mass of the whole robot.
    pub fn centre_of_mass(&self, model: &RobotModel) -> DVec3 {
        let moment: DVec3 = model
            .links
            .iter()
            .zip(&self.world_from_link)
            .map(|(link, pose)| link.mass * (*pose * link.com))
            .sum();
        moment / model.mass()
    }

    /// The axis of a joint in the world, and a point on it.
    pub fn joint_axis(&self, model: &RobotModel, joint: usize) -> (DVec3, DVec3) {
        let world_from_child = &self.world_from_link[model.joints[joint].child];
        (world_from_child.rotation * model.joints[joint].axis, world_from_child.translation)
    }

    /// The joint torques (N m) or forces (N) that hold the robot against gravity with its root
    /// fixed: the derivative of the potential energy, for each joint the weight of the links beyond
    /// it times its lever arm about the axis.
    pub fn gravity_torques(&self, model: &RobotModel) -> Vec<f64> {
        let mut mass: Vec<f64> = model.links.iter().map(|link| link.mass).collect();
        let mut moment: Vec<DVec3> = model
            .links
            .iter()
            .zip(&self.world_from_link)
            .map(|(link, pose)| link.mass * (*pose * link.com))
            .collect();
        for (index, link) in model.links.iter().enumerate().rev() {
            if let Some(attachment) = &link.parent {
                mass[attachment.parent] += mass[index];
                let beyond = moment[index];
                moment[attachment.parent] += beyond;
            }
        }
        let lift = |joint: usize| {
            let child = model.joints[joint].child;
            let centre = if mass[child] > 0.0 { moment[child] / mass[child] } else { DVec3::ZERO };
            self.along_joint(model, joint, centre, mass[child] * GRAVITY * DVec3::Z)
        };
        (0..model.joints.len()).map(lift).collect()
    }

    /// The joint torques (N m) or forces (N) of a robot at rest on one foot: the contact force
    /// carries the whole weight through the centre of mass, which unloads the joints between the
    /// root and that foot.
    pub fn standing_torques(&self, model: &RobotModel, limb: LimbIndex) -> Vec<f64> {
        let (weight, centre) = (model.mass() * GRAVITY * DVec3::Z, self.centre_of_mass(model));
        let mut torques = self.gravity_torques(model);
        for joint in model.chain(model.feet[limb].link) {
            torques[joint] -= self.along_joint(model, joint, centre, weight);
        }
        torques
    }

    /// The part of a force (N) through a point (m, both in the world) that acts along a joint's
    /// motion.
    pub fn along_joint(&self, model: &RobotModel, joint: usize, point: DVec3, force: DVec3) -> f64 {
        along_axis(model.joints[joint].kind, self.joint_axis(model, joint), point, force)
    }
}

/// The part of a force (N) through a point (m) that acts along a joint's motion, by its axis and a
/// point on it.
pub fn along_axis(
    kind: JointKind,
    (axis, origin): (DVec3, DVec3),
    point: DVec3,
    force: DVec3,
) -> f64 {
    match kind {
        JointKind::Revolute => axis.dot((point - origin).cross(force)),
        JointKind::Prismatic => axis.dot(force),
    }
}

fn joint_motion(kind: JointKind, axis: DVec3, position: f64) -> Pose {
    match kind {
        JointKind::Revolute => Pose::from_parts(DVec3::ZERO, rotation_about(axis, position)),
        JointKind::Prismatic => Pose::from_parts(axis * position, glam::DQuat::IDENTITY),
    }
}
