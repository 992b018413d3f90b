//! One leg: the joints that carry a foot and no other, and which joint positions put its sole where
//! it shall be. A joint that carries both feet, as a waist does between a root in the trunk and the
//! hips, belongs to no leg: it is held as the robot stands.

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{Joint, JointIndex, JointKind, LimbIndex, RobotModel};

use crate::kinematics::closed_form::ClosedForm;
use crate::kinematics::newton::Newton;

/// Most joints of a leg.
pub const LEG_JOINTS_MAX: usize = 8;

/// The positions of a leg's joints, root first.
pub type LegPositions = BoundedVec<f64, LEG_JOINTS_MAX>;

/// A leg whose joints cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LegError {
    /// Fewer than six or more than [`LEG_JOINTS_MAX`] joints.
    #[error(
        "the leg to foot '{foot}' has {joints} moving joints of its own; 6 to {LEG_JOINTS_MAX} are needed to place a sole freely"
    )]
    JointCount {
        /// The foot's name.
        foot: String,
        /// How many moving joints lead to it.
        joints: usize,
    },
}

/// A joint of a leg with the leg at position zero, in the root's frame.
#[derive(Debug, Clone, Copy)]
pub struct LegJoint {
    /// Index into `q`.
    pub index: JointIndex,
    /// Rotation or translation.
    pub kind: JointKind,
    /// A point on the axis.
    pub point: DVec3,
    /// The axis, unit.
    pub axis: DVec3,
    /// Lower limit with the planner's margin.
    pub lower: f64,
    /// Upper limit with the planner's margin.
    pub upper: f64,
}

/// A leg, compiled for inverse kinematics.
#[derive(Debug, Clone)]
pub struct Leg {
    joints: BoundedVec<LegJoint, LEG_JOINTS_MAX>,
    zero_root_from_sole: Pose,
    solver: Solver,
    hip: DVec3,
    sole_from_ankle: DVec3,
    reach: f64,
}

#[derive(Debug, Clone)]
#[allow(
    clippy::large_enum_variant,
    reason = "there are two of them, and a box would be one more step to each solution"
)]
enum Solver {
    ClosedForm(ClosedForm),
    Newton(Newton),
}

impl Leg {
    /// Compiles the leg to foot `limb`. Joints stay `joint_margin` from their limits.
    ///
    /// # Errors
    /// The leg has too few or too many joints.
    pub fn new(model: &RobotModel, limb: LimbIndex, joint_margin: f64) -> Result<Self, LegError> {
        let foot = &model.feet[limb];
        let chain = model.leg(limb);
        if !(6..=LEG_JOINTS_MAX).contains(&chain.len()) {
            return Err(LegError::JointCount { foot: foot.name.clone(), joints: chain.len() });
        }
        let zero = zero_poses(model, &chain);
        let joints: BoundedVec<_, LEG_JOINTS_MAX> =
            chain.iter().map(|&index| leg_joint(model, &zero, index, joint_margin)).collect();
        let zero_root_from_sole = zero[foot.link] * foot.link_from_sole;
        let solver = match ClosedForm::detect(&joints, &zero_root_from_sole) {
            Some(closed_form) => Solver::ClosedForm(closed_form),
            None => Solver::Newton(Newton::new(&joints, &zero_root_from_sole, &model.standing_q)),
        };
        let (hip, ankle) = (joints[1].point, joints[joints.len() - 1].point);
        let reach = joints[1..].windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum();
        let sole_from_ankle = zero_root_from_sole.inverse_transform_point(ankle);
        Ok(Self { joints, zero_root_from_sole, solver, hip, sole_from_ankle, reach })
    }

    /// Whether the leg has a closed-form solution.
    pub fn is_closed_form(&self) -> bool {
        matches!(self.solver, Solver::ClosedForm(_))
    }

    /// The leg's joints, root first.
    pub fn joints(&self) -> &[LegJoint] {
        &self.joints
    }

    /// The hip's centre in the root's frame.
    pub fn hip(&self) -> DVec3 {
        self.hip
    }

    /// The ankle's centre in the sole's frame.
    pub fn sole_from_ankle(&self) -> DVec3 {
        self.sole_from_ankle
    }

    /// The longest distance between hip and ankle, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Writes the leg's part of `q` so that the sole stands at `root_from_sole`, choosing among the
    /// solutions within the limits the one nearest to what `q` holds. Leaves `q` alone and answers
    /// `false` where there is none.
    pub fn solve(&self, root_from_sole: &Pose, q: &mut [f64]) -> bool {
        self.solve_by(root_from_sole, q, Newton::solve)
    }

    /// The same, but where there is no closed form only a solution to which the iteration leads
    /// from what `q` holds or from the standing posture.
    pub fn solve_near(&self, root_from_sole: &Pose, q: &mut [f64]) -> bool {
        self.solve_by(root_from_sole, q, Newton::solve_near)
    }

    fn solve_by(
        &self,
        root_from_sole: &Pose,
        q: &mut [f64],
        iterate: impl Fn(&Newton, &[LegJoint], &Pose, &LegPositions) -> Option<LegPositions>,
    ) -> bool {
        let near: LegPositions = self.joints.iter().map(|joint| q[joint.index]).collect();
        let found = match &self.solver {
            Solver::ClosedForm(closed_form) => {
                closed_form.solve(&self.joints, root_from_sole, &near)
            }
            Solver::Newton(newton) => iterate(newton, &self.joints, root_from_sole, &near),
        };
        let Some(found) = found else { return false };
        for (joint, position) in self.joints.iter().zip(found) {
            q[joint.index] = position;
        }
        true
    }

    /// The leg's joints, each with the motion of what carries it: takes its point and axis to where
    /// they are, in the root's frame.
    pub fn axes(&self, q: &[f64]) -> impl Iterator<Item = (&LegJoint, Pose)> {
        self.joints.iter().scan(Pose::IDENTITY, move |motion, joint| {
            let before = *motion;
            *motion = before * joint.motion(q[joint.index]);
            Some((joint, before))
        })
    }

    /// The sole's pose in the root's frame.
    pub fn root_from_sole(&self, q: &[f64]) -> Pose {
        let motion = self
            .joints
            .iter()
            .fold(Pose::IDENTITY, |motion, joint| motion * joint.motion(q[joint.index]));
        motion * self.zero_root_from_sole
    }
}

impl LegJoint {
    /// What moving to `position` does to everything beyond the joint, in the root's frame with all
    /// joints before at zero.
    pub fn motion(&self, position: f64) -> Pose {
        match self.kind {
            JointKind::Revolute => {
                let rotation =
                    surefoot_shared_types::base::spatial::rotation_about(self.axis, position);
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

fn leg_joint(model: &RobotModel, zero: &[Pose], index: JointIndex, margin: f64) -> LegJoint {
    let joint = &model.joints[index];
    let world_from_joint = zero[joint.child];
    let [lower, upper] = limits_within(joint, margin);
    LegJoint {
        index,
        kind: joint.kind,
        point: world_from_joint.translation,
        axis: world_from_joint.rotation * joint.axis,
        lower,
        upper,
    }
}

/// A joint's limits with a margin on either side; the middle of them where there is no room for
/// that.
pub fn limits_within(joint: &Joint, margin: f64) -> [f64; 2] {
    let middle = joint.lower.midpoint(joint.upper);
    [(joint.lower + margin).min(middle), (joint.upper - margin).max(middle)]
}

/// All links in the root's frame, the joints of a leg at zero, all others as the robot stands.
fn zero_poses(model: &RobotModel, leg: &[JointIndex]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; model.links.len()];
    let q: Vec<f64> = model
        .standing_q
        .iter()
        .enumerate()
        .map(|(joint, &standing)| if leg.contains(&joint) { 0.0 } else { standing })
        .collect();
    crate::kinematics::forward::Kinematics::new(model).forward(&Pose::IDENTITY, &q, &mut poses);
    poses
}
