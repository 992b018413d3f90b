//! The motion of links: poses and velocities by forward kinematics.

use glam::DVec3;
use surefoot_shared_types::base::spatial::Pose;
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::robot::model::{JointKind, RobotModel};

/// The motion of a link's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMotion {
    /// The link's pose.
    pub world_from_link: Pose,
    /// Velocity of the link's origin along the world's axes, m/s.
    pub velocity: DVec3,
    /// Angular velocity along the world's axes, rad/s.
    pub angular_velocity: DVec3,
}

/// The motion of every link.
pub fn body_motions(model: &RobotModel, waypoint: &Waypoint) -> Vec<BodyMotion> {
    let [vx, vy, vz, wx, wy, wz] = waypoint.root_velocity;
    let root = BodyMotion {
        world_from_link: waypoint.world_from_root(),
        velocity: DVec3::new(vx, vy, vz),
        angular_velocity: DVec3::new(wx, wy, wz),
    };
    let mut motions: Vec<BodyMotion> = Vec::with_capacity(model.links.len());
    for link in &model.links {
        let Some(attachment) = &link.parent else {
            motions.push(root);
            continue;
        };
        let parent = motions[attachment.parent];
        let world_from_joint = parent.world_from_link * attachment.parent_from_joint;
        let mut motion = BodyMotion { world_from_link: world_from_joint, ..parent };
        let mut slide = DVec3::ZERO;
        if let Some(index) = attachment.joint {
            let joint = &model.joints[index];
            let (position, speed) = (waypoint.q[index], waypoint.joint_velocity[index]);
            let axis = world_from_joint.rotation * joint.axis;
            motion.world_from_link = world_from_joint * joint.kind.motion(joint.axis, position);
            match joint.kind {
                JointKind::Revolute => motion.angular_velocity += speed * axis,
                JointKind::Prismatic => slide = speed * axis,
            }
        }
        let arm = motion.world_from_link.translation - parent.world_from_link.translation;
        motion.velocity = parent.velocity + parent.angular_velocity.cross(arm) + slide;
        motions.push(motion);
    }
    motions
}

/// The pose of a foot's sole in the world.
pub fn world_from_sole(model: &RobotModel, motions: &[BodyMotion], limb: usize) -> Pose {
    let foot = &model.feet[limb];
    motions[foot.link].world_from_link * foot.link_from_sole
}

/// The centre of mass in the world, m, and its velocity, m/s.
pub fn centre_of_mass(model: &RobotModel, motions: &[BodyMotion]) -> (DVec3, DVec3) {
    let mut moment = [DVec3::ZERO; 2];
    for (link, motion) in model.links.iter().zip(motions) {
        let arm = motion.world_from_link.rotation * link.com;
        moment[0] += link.mass * (motion.world_from_link.translation + arm);
        moment[1] += link.mass * (motion.velocity + motion.angular_velocity.cross(arm));
    }
    let mass = model.mass();
    (moment[0] / mass, moment[1] / mass)
}
