//! Inverse kinematics of one leg: joint positions that place its sole at a pose.
//!
//! A leg consists of the joints that carry its foot and no other. A joint that carries both feet,
//! such as a waist between a root in the trunk and the hips, belongs to no leg and keeps its
//! standing position.

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{JointIndex, LimbIndex, RobotModel};

use crate::kinematics::closed_form::ClosedForm;
use crate::kinematics::forward::Kinematics;
use crate::kinematics::leg_joint::{LEG_JOINTS_MAX, LegJoint, LegPositions};
use crate::kinematics::newton::Newton;

/// A leg whose joints cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LegError {
    /// Fewer than six or more than `LEG_JOINTS_MAX` joints.
    #[error(
        "the leg to foot '{foot}' has {joints} moving joints of its own; \
         6 to {LEG_JOINTS_MAX} are needed to place a sole freely"
    )]
    JointCount {
        /// Name of the foot.
        foot: String,
        /// Number of moving joints of the leg.
        joints: usize,
    },
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
    reason = "a robot has two legs, and a box would add an indirection to each solution"
)]
enum Solver {
    ClosedForm(ClosedForm),
    Newton(Newton),
}

impl Leg {
    /// Compiles the leg of foot `limb`. Solutions keep `joint_margin` (rad or m) to joint limits.
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
        let mut joints: BoundedVec<_, LEG_JOINTS_MAX> =
            chain.iter().map(|&index| LegJoint::new(model, &zero, index, joint_margin)).collect();
        let ends = [joints[1].point, joints[joints.len() - 1].point];
        let knee = joints.iter_mut().max_by(|a, b| a.bends_by(ends).total_cmp(&b.bends_by(ends)));
        if let Some(knee) = knee {
            knee.keep_bent(ends);
        }
        let zero_root_from_sole = zero[foot.link] * foot.link_from_sole;
        let solver = match ClosedForm::detect(&joints, &zero_root_from_sole) {
            Some(closed_form) => Solver::ClosedForm(closed_form),
            None => Solver::Newton(Newton::new(&joints, &zero_root_from_sole, &model.standing_q)),
        };
        let [hip, ankle] = ends;
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

    /// Centre of the hip in the root frame, m.
    pub fn hip(&self) -> DVec3 {
        self.hip
    }

    /// Centre of the ankle in the sole frame, m.
    pub fn sole_from_ankle(&self) -> DVec3 {
        self.sole_from_ankle
    }

    /// Largest distance between hip and ankle, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Used part of the leg's reach, 0 to 1.
    pub(crate) fn extension(&self, q: &[f64]) -> f64 {
        let ankle = self.root_from_sole(q) * self.sole_from_ankle;
        ankle.distance(self.hip) / self.reach
    }

    /// Writes the leg's positions into `q` so that the sole is at `root_from_sole`: of the
    /// solutions within the limits the one nearest to the positions in `q`. Returns `false` and
    /// leaves `q` unchanged if there is none.
    pub fn solve(&self, root_from_sole: &Pose, q: &mut [f64]) -> bool {
        self.solve_by(root_from_sole, q, Newton::solve)
    }

    /// As [`Self::solve`], but a leg without closed form is solved by iterations from the positions
    /// in `q` and from the standing posture alone: cheaper where there is no solution.
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

    /// The leg's joints, each with the displacement of the link that carries it: it maps the
    /// joint's point and axis to their places in the root frame.
    pub fn axes(&self, q: &[f64]) -> impl Iterator<Item = (&LegJoint, Pose)> {
        self.joints.iter().scan(Pose::IDENTITY, move |motion, joint| {
            let before = *motion;
            *motion = before * joint.motion(q[joint.index]);
            Some((joint, before))
        })
    }

    /// Pose of the sole in the root frame.
    pub fn root_from_sole(&self, q: &[f64]) -> Pose {
        let motion = self
            .joints
            .iter()
            .fold(Pose::IDENTITY, |motion, joint| motion * joint.motion(q[joint.index]));
        motion * self.zero_root_from_sole
    }
}

/// Root-frame poses of all links, with the joints of a leg at 0 and all others in the standing
/// posture.
fn zero_poses(model: &RobotModel, leg: &[JointIndex]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; model.links.len()];
    let q: Vec<f64> = model
        .standing_q
        .iter()
        .enumerate()
        .map(|(joint, &standing)| if leg.contains(&joint) { 0.0 } else { standing })
        .collect();
    Kinematics::new(model).forward(&Pose::IDENTITY, &q, &mut poses);
    poses
}
