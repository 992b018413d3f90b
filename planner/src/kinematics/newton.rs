//! Bounded numeric inverse kinematics of a leg without a closed form.
//!
//! Newton steps start from the caller's positions, then from the standing posture, then from those
//! stored postures whose soles are nearest to the target.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::robot::model::JointKind;

use crate::base::random::{Random, Stream};
use crate::kinematics::leg_chain::{LegChain, Vector6};
use crate::kinematics::leg_joint::{LEG_JOINTS_MAX, LegJoint, LegPositions};
use crate::kinematics::newton_step::newton_step;
use crate::kinematics::tuning::{
    APPROACH_ITERATIONS, ERROR_NEAR, ITERATIONS_MAX, JOINT_STEP_MAX, LENGTH_PER_DOUBLE_RADIAN,
    LIMIT_STEPS_MAX, POSTURE_STARTS, POSTURES, PROGRESS_RATIO_MAX, STALLS_MAX,
    STANDING_DEVIATION_MAX,
};

/// Cosine of half the largest rotation (0.4 rad) whose chord replaces its arc.
const COS_HALF_SMALL: f64 = 0.98;
/// Largest error of a solution, m and rad.
const TOLERANCE: f64 = 1e-9;
/// Bound of the rounding error of a length, m.
const LENGTH_ROUNDING: f64 = 1e-9;

/// The chain and the start postures of a leg.
#[derive(Debug, Clone)]
pub(crate) struct Newton {
    chain: LegChain,
    sole_from_ankle: DVec3,
    reach: f64,
    standing: LegPositions,
    postures: Vec<StartPosture>,
}

/// A posture of the leg with the pose of its sole.
#[derive(Debug, Clone)]
struct StartPosture {
    root_from_sole: Pose,
    positions: LegPositions,
}

impl Newton {
    /// Prepares the iteration. `zero_root_from_sole` is the sole's pose with all joints at 0,
    /// `standing_q` the standing posture of the robot.
    pub(crate) fn new(joints: &[LegJoint], zero_root_from_sole: &Pose, standing_q: &[f64]) -> Self {
        let standing: LegPositions = joints.iter().map(|joint| standing_q[joint.index]).collect();
        let ankle = joints[joints.len() - 1].point;
        let mut newton = Self {
            chain: LegChain::new(joints, zero_root_from_sole),
            sole_from_ankle: zero_root_from_sole.inverse_transform_point(ankle),
            reach: reach_bound(joints),
            standing,
            postures: Vec::with_capacity(POSTURES),
        };
        for index in 0..POSTURES {
            let positions = newton.sample_posture(joints, index);
            let root_from_sole =
                newton.chain.forward(joints, &positions, &mut [[0.0; 6]; LEG_JOINTS_MAX]);
            newton.postures.push(StartPosture { root_from_sole, positions });
        }
        newton
    }

    fn sample_posture(&self, joints: &[LegJoint], index: usize) -> LegPositions {
        let mut random = Random::new(0, Stream::Preparation, 1 << 33, index as u64);
        let near_standing = index < POSTURES / 2;
        let sample = |(joint, &standing): (&LegJoint, &f64)| {
            let deviation = if near_standing { STANDING_DEVIATION_MAX } else { f64::INFINITY };
            random.uniform(
                joint.lower.max(standing - deviation),
                joint.upper.min(standing + deviation),
            )
        };
        joints.iter().zip(&self.standing).map(sample).collect()
    }

    /// A solution within the limits: from `near`, else from the standing posture, else from stored
    /// postures.
    pub(crate) fn solve(
        &self,
        joints: &[LegJoint],
        root_from_sole: &Pose,
        near: &LegPositions,
    ) -> Option<LegPositions> {
        self.solve_near(joints, root_from_sole, near).or_else(|| {
            self.is_within_reach(joints, root_from_sole).then(|| {
                self.nearest_postures(root_from_sole).into_iter().find_map(|index| {
                    self.iterate(joints, root_from_sole, &self.postures[index].positions)
                })
            })?
        })
    }

    /// Does the same without the stored postures: for samples, most of which have no solution.
    pub(crate) fn solve_near(
        &self,
        joints: &[LegJoint],
        root_from_sole: &Pose,
        near: &LegPositions,
    ) -> Option<LegPositions> {
        if !self.is_within_reach(joints, root_from_sole) {
            return None;
        }
        let standing = (near != &self.standing).then_some(&self.standing);
        std::iter::once(near)
            .chain(standing)
            .find_map(|start| self.iterate(joints, root_from_sole, start))
    }

    /// Whether the ankle of the target is not farther from the first joint than the leg is long.
    fn is_within_reach(&self, joints: &[LegJoint], root_from_sole: &Pose) -> bool {
        (*root_from_sole * self.sole_from_ankle).distance(joints[0].point) <= self.reach
    }

    /// Indices of the stored postures whose soles are nearest to the target, nearest first.
    fn nearest_postures(&self, root_from_sole: &Pose) -> [usize; POSTURE_STARTS] {
        let mut nearest = [(f64::INFINITY, 0); POSTURE_STARTS];
        for (index, posture) in self.postures.iter().enumerate() {
            let shift =
                (posture.root_from_sole.translation - root_from_sole.translation).length_squared();
            let aligned = posture.root_from_sole.rotation.dot(root_from_sole.rotation);
            let mut candidate = (
                shift / (LENGTH_PER_DOUBLE_RADIAN * LENGTH_PER_DOUBLE_RADIAN)
                    + 4.0 * (1.0 - aligned * aligned),
                index,
            );
            for kept in &mut nearest {
                if candidate.0 < kept.0 {
                    std::mem::swap(kept, &mut candidate);
                }
            }
        }
        nearest.map(|(_, index)| index)
    }

    /// Newton steps from one start; `None` if they do not converge within the limits.
    fn iterate(
        &self,
        joints: &[LegJoint],
        target: &Pose,
        start: &LegPositions,
    ) -> Option<LegPositions> {
        let mut q = start.clone();
        let (mut least, mut stalls, mut limit_steps) = (f64::INFINITY, 0, 0);
        for iteration in 0..ITERATIONS_MAX {
            let mut columns = [[0.0; 6]; LEG_JOINTS_MAX];
            let reached = self.chain.forward(joints, &q, &mut columns);
            let error = twist(&reached, target);
            if error.iter().all(|e| e.abs() < TOLERANCE) {
                return joints
                    .iter()
                    .zip(&q)
                    .all(|(joint, &position)| joint.is_within_limits(position))
                    .then_some(q);
            }
            let size = error.iter().fold(0.0_f64, |size, e| size.max(e.abs()));
            stalls = if size > PROGRESS_RATIO_MAX * least { stalls + 1 } else { 0 };
            least = least.min(size);
            if stalls == STALLS_MAX || iteration == APPROACH_ITERATIONS && size > ERROR_NEAR {
                return None;
            }
            let step = newton_step(&columns[..joints.len()], &error)?;
            limit_steps = if take_step(joints, &mut q, &step) { limit_steps + 1 } else { 0 };
            if limit_steps == LIMIT_STEPS_MAX {
                return None;
            }
        }
        None
    }
}

/// Moves the joints by a step, shortened to [`JOINT_STEP_MAX`] and clamped to the limits. Returns
/// whether a joint was clamped.
fn take_step(joints: &[LegJoint], q: &mut LegPositions, step: &LegPositions) -> bool {
    let longest = step.iter().fold(0.0_f64, |longest, s| longest.max(s.abs()));
    let scale = if longest > JOINT_STEP_MAX { JOINT_STEP_MAX / longest } else { 1.0 };
    let mut is_at_limit = false;
    for ((position, s), joint) in q.iter_mut().zip(step).zip(joints) {
        let desired = *position + scale * s;
        is_at_limit |= !joint.is_within_limits(desired);
        *position = desired.clamp(joint.lower, joint.upper);
    }
    is_at_limit
}

/// Upper bound of the distance between the first and the last joint's points, m.
fn reach_bound(joints: &[LegJoint]) -> f64 {
    let links: f64 = joints.windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum();
    let slides = joints.iter().filter(|joint| joint.kind == JointKind::Prismatic);
    links
        + slides.map(|joint| joint.lower.abs().max(joint.upper.abs())).sum::<f64>()
        + LENGTH_ROUNDING
}

/// The twist that moves one pose to another.
fn twist(from: &Pose, to: &Pose) -> Vector6 {
    let linear = to.translation - from.translation;
    let rotation = to.rotation * from.rotation.conjugate();
    // For a small rotation the chord leads to the same solution, without an arc tangent.
    let angular = if rotation.w > COS_HALF_SMALL {
        2.0 * rotation.xyz()
    } else {
        scaled_axis_from_rotation(rotation)
    };
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}
