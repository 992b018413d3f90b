//! Robots whose root link points elsewhere than ahead: a frame of their own turns it.

use glam::{DMat3, DQuat, DVec3};

use crate::base::spatial::Pose;

use crate::robot::model::{Attachment, Link, RobotModel};

/// What the name of the turned root adds to the URDF's.
const SUFFIX: &str = " (turned)";

/// Hangs a robot on a new root at the same place, which stands at `urdf_root_from_root` in the
/// URDF's root link.
pub(crate) fn turn_root(robot: &mut RobotModel, urdf_root_from_root: DQuat) {
    for attachment in robot.links.iter_mut().filter_map(|link| link.parent.as_mut()) {
        attachment.parent += 1;
    }
    let joints = robot.joints.iter_mut();
    let locked = robot.locked_joints.iter_mut().map(|locked| &mut locked.joint);
    joints.chain(locked).for_each(|joint| joint.child += 1);
    robot.feet.iter_mut().for_each(|foot| foot.link += 1);
    let parent_from_joint = Pose::from_rotation(urdf_root_from_root.inverse());
    robot.links[0].parent = Some(Attachment { parent: 0, parent_from_joint, joint: None });
    let root = Link {
        name: robot.links[0].name.clone() + SUFFIX,
        parent: None,
        mass: 0.0,
        com: DVec3::ZERO,
        inertia: DMat3::ZERO,
        shapes: Vec::new(),
    };
    robot.links.insert(0, root);
}

impl RobotModel {
    /// The URDF's root link in the planned root's frame; the same link unless the robot file turns
    /// it.
    pub fn root_from_urdf_root(&self) -> Pose {
        let [root, urdf_root, ..] = &self.links[..] else { return Pose::IDENTITY };
        let is_turned = root.name.strip_suffix(SUFFIX) == Some(urdf_root.name.as_str());
        let attachment = urdf_root.parent.as_ref().filter(|_| is_turned);
        attachment.map_or(Pose::IDENTITY, |attachment| attachment.parent_from_joint)
    }
}
