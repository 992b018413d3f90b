//! The joints that carry no foot.

use surefoot_shared_types::robot::model::RobotModel;

use crate::kinematics::leg_joint::limits_within;
use crate::robot::mass_tree::MassTree;
use crate::robot::tuning::{FINGER_MASS_SHARE_MAX, TRUNK_MASS_SHARE_MIN};

/// Most joints that carry the trunk.
pub(crate) const TRUNK_JOINTS_MAX: usize = 4;

/// A joint that carries no foot. It is free in every mode.
#[derive(Debug, Clone, Copy)]
pub struct FreeJoint {
    /// Index into `q`.
    pub index: usize,
    /// Lower limit with the planner's margin, rad or m; the standing position where that is lower.
    pub lower: f64,
    /// Upper limit with the planner's margin, rad or m; the standing position where that is higher.
    pub upper: f64,
    /// Whether samples move it. Finger joints keep their standing positions: they neither balance
    /// the robot nor clear obstacles.
    pub is_sampled: bool,
}

/// All joints that carry no foot, in joint order; `margin` (rad or m) is kept to their limits by
/// all but those that stand nearer to them.
pub(crate) fn free_joints(model: &RobotModel, margin: f64, mass_tree: &MassTree) -> Vec<FreeJoint> {
    let of_legs: Vec<usize> = model.feet.iter().flat_map(|foot| model.chain(foot.link)).collect();
    let free = model.joints.iter().enumerate().filter(|(index, _)| !of_legs.contains(index));
    let within = |(index, joint)| {
        let [lower, upper] = limits_within(joint, margin);
        let is_sampled = mass_tree.carried_mass(index) >= FINGER_MASS_SHARE_MAX * mass_tree.mass();
        let standing = model.standing_q[index];
        FreeJoint { index, lower: lower.min(standing), upper: upper.max(standing), is_sampled }
    };
    free.map(within).collect()
}

/// The first [`TRUNK_JOINTS_MAX`] free joints that carry the trunk, seen from the root.
pub(crate) fn trunk_joints(free_joints: &[FreeJoint], mass_tree: &MassTree) -> Vec<FreeJoint> {
    let carries_trunk = |joint: &&FreeJoint| {
        mass_tree.carried_mass(joint.index) >= TRUNK_MASS_SHARE_MIN * mass_tree.mass()
    };
    free_joints.iter().filter(carries_trunk).take(TRUNK_JOINTS_MAX).copied().collect()
}
