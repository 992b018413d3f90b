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

/// A knee that can be bent backward by at most this angle is never bent so, rad.
const OVEREXTENSION_MAX: f64 = 0.3;
/// The least angle by which such a knee stays bent, rad.
const STRAIGHT_MARGIN: f64 = 0.02;

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

    /// Keeps a knee from bending backward: where the leg is longest within the range of its knee,
    /// short of the nearer end by little, that end moves to the other side of it. Past it the leg
    /// bends the other way, and no smooth motion of the root leads there. `ends` are the centres of
    /// hip and ankle with the leg at 0.
    pub(crate) fn keep_bent(&mut self, ends: [DVec3; 2]) {
        let straight = self.straight_position(ends);
        let [below, above] = [straight - self.lower, self.upper - straight];
        let shorter = below.min(above);
        if shorter <= 0.0 || shorter > OVEREXTENSION_MAX {
            return;
        }
        if below <= above {
            self.lower = straight + STRAIGHT_MARGIN;
        } else {
            self.upper = straight - STRAIGHT_MARGIN;
        }
    }

    /// The position at which the two points are farthest apart.
    fn straight_position(&self, ends: [DVec3; 2]) -> f64 {
        let [hip, ankle] = self.arms(ends);
        libm::atan2(self.axis.dot(ankle.cross(-hip)), ankle.dot(-hip))
    }

    /// How far the distance of the two points changes with the joint, by its square, m2.
    pub(crate) fn bends_by(&self, ends: [DVec3; 2]) -> f64 {
        let [hip, ankle] = self.arms(ends).map(DVec3::length);
        if self.kind == JointKind::Revolute { hip * ankle } else { 0.0 }
    }

    /// The ways from the axis to two points.
    fn arms(&self, ends: [DVec3; 2]) -> [DVec3; 2] {
        ends.map(|end| (end - self.point).reject_from_normalized(self.axis))
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

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [DVec3; 2] = [DVec3::ZERO, DVec3::new(0.0, 0.0, -0.66)];

    fn knee(axis: DVec3, lower: f64, upper: f64) -> LegJoint {
        let point = DVec3::new(0.0, 0.0, -0.33);
        LegJoint { index: 3, kind: JointKind::Revolute, point, axis, lower, upper }
    }

    fn kept_bent(mut knee: LegJoint) -> [f64; 2] {
        knee.keep_bent(ENDS);
        [knee.lower, knee.upper]
    }

    #[test]
    fn a_knee_with_a_short_range_loses_the_shorter_side() {
        assert_eq!(kept_bent(knee(DVec3::Y, -0.2, 0.01)), [-0.2, -STRAIGHT_MARGIN]);
        assert_eq!(kept_bent(knee(DVec3::Y, -0.01, 0.2)), [STRAIGHT_MARGIN, 0.2]);
        assert_eq!(kept_bent(knee(DVec3::Y, 0.1, 0.25)), [0.1, 0.25], "never straight");
    }

    #[test]
    fn a_knee_that_bends_backward_a_little_stays_bent_forward() {
        assert_eq!(kept_bent(knee(DVec3::Y, -0.07, 2.6)), [STRAIGHT_MARGIN, 2.6]);
        assert_eq!(kept_bent(knee(DVec3::NEG_Y, -2.6, 0.07)), [-2.6, -STRAIGHT_MARGIN]);
        // A thigh that leans by 0.4 rad where the joint is at 0.
        let leaning = LegJoint {
            point: DVec3::new(0.33 * libm::sin(0.2), 0.0, -0.33),
            ..knee(DVec3::Y, -0.5, 2.0)
        };
        let [lower, _] = kept_bent(leaning);
        assert!((leaning.straight_position(ENDS) + STRAIGHT_MARGIN - lower).abs() < 1e-12);
        let reach_at = |q: f64| (leaning.motion(q) * ENDS[1]).length();
        let straight = lower - STRAIGHT_MARGIN;
        assert!(reach_at(straight) > reach_at(straight + 0.01));
        assert!(reach_at(straight) > reach_at(straight - 0.01));
    }

    #[test]
    fn a_knee_that_bends_either_way_or_never_is_straight_keeps_its_range() {
        assert_eq!(kept_bent(knee(DVec3::Y, -1.0, 1.0)), [-1.0, 1.0]);
        assert_eq!(kept_bent(knee(DVec3::Y, 0.1, 2.6)), [0.1, 2.6]);
    }

    #[test]
    fn the_knee_bends_a_leg_more_than_hips_and_ankles() {
        let at = |z: f64| LegJoint { point: DVec3::new(0.0, 0.0, z), ..knee(DVec3::Y, -1.0, 1.0) };
        let bends = [0.0, -0.33, -0.66].map(|z| at(z).bends_by(ENDS));
        assert!(bends[1] > bends[0].max(bends[2]), "{bends:?}");
    }
}
