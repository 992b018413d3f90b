//! Bounded numeric inverse kinematics for a leg without a closed form: damped Newton steps from a few starts.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::JointKind;
use surefoot_shared_types::spatial::scaled_axis_from_rotation;

use super::leg::{LegJoint, LegPositions};

/// Newton steps from one start; from near the solution three or four suffice.
const ITERATIONS_MAX: usize = 16;
/// A solution's largest error, m and rad.
const TOLERANCE: f64 = 1e-9;
/// The longest joint motion of one step, rad or m: keeps far starts from leaping across branches.
const STEP_MAX: f64 = 0.5;
/// Damping of the normal equations; small enough to leave convergence superlinear.
const DAMPING: f64 = 1e-9;

/// The starts and the zero pose of a leg.
#[derive(Debug, Clone)]
pub struct Newton {
    zero_root_from_sole: Pose,
    standing: LegPositions,
}

type Vector6 = [f64; 6];

impl Newton {
    /// Prepares the iteration; `standing_q` is the second start after the caller's own.
    pub fn new(joints: &[LegJoint], zero_root_from_sole: &Pose, standing_q: &[f64]) -> Self {
        Self { zero_root_from_sole: *zero_root_from_sole, standing: joints.iter().map(|joint| standing_q[joint.index]).collect() }
    }

    /// A solution within the limits, from `near` or else from the standing posture.
    pub fn solve(&self, joints: &[LegJoint], root_from_sole: &Pose, near: &LegPositions) -> Option<LegPositions> {
        [near, &self.standing].into_iter().find_map(|start| self.descend(joints, root_from_sole, start))
    }

    fn descend(&self, joints: &[LegJoint], target: &Pose, start: &LegPositions) -> Option<LegPositions> {
        let mut q = start.clone();
        for _ in 0..ITERATIONS_MAX {
            let mut columns = [[0.0; 6]; super::leg::LEG_JOINTS_MAX];
            let reached = self.forward(joints, &q, &mut columns);
            let error = twist(&reached, target);
            if error.iter().all(|e| e.abs() < TOLERANCE) {
                return joints.iter().zip(&q).all(|(joint, &position)| joint.admits(position)).then_some(q);
            }
            let step = least_squares(&columns[..joints.len()], &error)?;
            let longest = step.iter().fold(0.0_f64, |longest, s| longest.max(s.abs()));
            let scale = if longest > STEP_MAX { STEP_MAX / longest } else { 1.0 };
            for ((position, s), joint) in q.iter_mut().zip(&step).zip(joints) {
                *position = (*position + scale * s).clamp(joint.lower, joint.upper);
            }
        }
        None
    }

    /// The sole's pose, and the twist (linear at the sole's origin, angular) of each joint.
    fn forward(&self, joints: &[LegJoint], q: &LegPositions, columns: &mut [Vector6]) -> Pose {
        let mut motion = Pose::IDENTITY;
        let mut axes = [(DVec3::ZERO, DVec3::ZERO); super::leg::LEG_JOINTS_MAX];
        for ((joint, &position), axis) in joints.iter().zip(q).zip(&mut axes) {
            *axis = (motion * joint.point, motion.rotation * joint.axis);
            motion *= joint.motion(position);
        }
        let sole = motion * self.zero_root_from_sole;
        for ((joint, (point, axis)), column) in joints.iter().zip(axes).zip(columns) {
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (axis.cross(sole.translation - point), axis),
                JointKind::Prismatic => (axis, DVec3::ZERO),
            };
            *column = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
        }
        sole
    }
}

fn twist(from: &Pose, to: &Pose) -> Vector6 {
    let linear = to.translation - from.translation;
    let angular = scaled_axis_from_rotation(to.rotation * from.rotation.conjugate());
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// The least-norm step `J^T (J J^T + damping)^-1 error`, one entry per column of J.
fn least_squares(columns: &[Vector6], error: &Vector6) -> Option<LegPositions> {
    let mut normal = [[0.0; 7]; 6];
    for (row, line) in normal.iter_mut().enumerate() {
        for (col, entry) in line[..6].iter_mut().enumerate() {
            *entry = columns.iter().map(|c| c[row] * c[col]).sum();
        }
        line[row] += DAMPING;
        line[6] = error[row];
    }
    let solution = eliminate(&mut normal)?;
    Some(columns.iter().map(|c| c.iter().zip(&solution).map(|(a, b)| a * b).sum()).collect())
}

/// Solves a 6 by 6 system given with its right-hand side as a seventh column; `None` where it is singular.
fn eliminate(system: &mut [[f64; 7]; 6]) -> Option<Vector6> {
    for pivot in 0..6 {
        let best = (pivot..6).max_by(|&a, &b| system[a][pivot].abs().total_cmp(&system[b][pivot].abs()))?;
        system.swap(pivot, best);
        if system[pivot][pivot].abs() < 1e-14 {
            return None;
        }
        let line = system[pivot];
        for row in system.iter_mut().skip(pivot + 1) {
            let factor = row[pivot] / line[pivot];
            for (entry, above) in row.iter_mut().zip(line).skip(pivot) {
                *entry -= factor * above;
            }
        }
    }
    let mut solution = [0.0; 6];
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|col| system[row][col] * solution[col]).sum();
        solution[row] = (system[row][6] - known) / system[row][row];
    }
    Some(solution)
}
