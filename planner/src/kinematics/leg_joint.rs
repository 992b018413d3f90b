//! The joints of a leg and their positions.

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::robot::model::{Joint, JointIndex, JointKind, RobotModel};

/// Most joints of a leg.
pub const LEG_JOINTS_MAX: usize = 8;

/// The positions of a leg's joints (rad or m), root first.
pub type LegPositions = BoundedVec<f64, LEG_JOINTS_MAX>;

/// A joint of a leg in the root frame, with all joints of the leg at 0.
#[derive(Debug, Clone, Copy)]
pub struct LegJoint {
    /// Index into `q`.
    pub index: JointIndex,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// A point on the axis, m.
    pub point: DVec3,
    /// Direction of the axis, of length 1.
    pub axis: DVec3,
    /// Lower limit with the planner's margin, rad or m.
    pub lower: f64,
    /// Upper limit with the planner's margin, rad or m.
    pub upper: f64,
}

impl LegJoint {
    /// A joint of the model; `zero` holds the root-frame poses of all links with the leg at 0.
    pub(crate) fn new(model: &RobotModel, zero: &[Pose], index: JointIndex, margin: f64) -> Self {
        let joint = &model.joints[index];
        let root_from_joint = zero[joint.child];
        let [lower, upper] = limits_within(joint, margin);
        Self {
            index,
            kind: joint.kind,
            point: root_from_joint.translation,
            axis: root_from_joint.rotation * joint.axis,
            lower,
            upper,
        }
    }

    /// The displacement of everything beyond the joint when it moves to `position` (rad or m), in
    /// the root frame with all joints before it at 0.
    pub fn motion(&self, position: f64) -> Pose {
        match self.kind {
            JointKind::Revolute => {
                let rotation = rotation_about(self.axis, position);
                Pose::from_parts(self.point - rotation * self.point, rotation)
            }
            JointKind::Prismatic => Pose::from_translation(self.axis * position),
        }
    }

    /// Whether a position is within the limits.
    pub fn is_within_limits(&self, position: f64) -> bool {
        (self.lower..=self.upper).contains(&position)
    }
}

/// A joint's limits, each moved inward by `margin` (rad or m) but not beyond their middle.
pub(crate) fn limits_within(joint: &Joint, margin: f64) -> [f64; 2] {
    let middle = joint.lower.midpoint(joint.upper);
    [(joint.lower + margin).min(middle), (joint.upper - margin).max(middle)]
}
