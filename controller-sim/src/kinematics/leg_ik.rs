//! Inverse kinematics of one leg for a sole pose near its current one: Newton's method on the
//! joints of the leg, damped where the leg is nearly straight.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;
use surefoot_shared_types::robot::model::{JointKind, LimbIndex, RobotModel};

use crate::base::linear_solve::solve;
use crate::kinematics::forward::{Configuration, Posture};

/// Newton steps; a millimetre takes three or four.
const IK_STEPS_MAX: usize = 20;
/// The sole is where it should be within this, m and rad.
const POSE_ERROR_MAX: f64 = 1e-10;
/// Added to the normal equations' diagonal.
const IK_DAMPING: f64 = 1e-9;

/// Moves the joints of one leg until its sole is at `world_from_sole`. False if it is not reached;
/// joint limits are the caller's to check.
pub fn solve_leg_ik(
    model: &RobotModel,
    configuration: &mut Configuration,
    limb: LimbIndex,
    world_from_sole: &Pose,
) -> bool {
    let chain = model.leg(limb);
    for _ in 0..IK_STEPS_MAX {
        let posture = Posture::new(model, configuration);
        let sole = posture.world_from_sole(model, limb);
        let translation_error = world_from_sole.translation - sole.translation;
        let rotation_error =
            scaled_axis_from_rotation(world_from_sole.rotation * sole.rotation.conjugate());
        let (t, r) = (translation_error, rotation_error);
        let pose_error = [t.x, t.y, t.z, r.x, r.y, r.z];
        if pose_error.iter().all(|value| value.abs() <= POSE_ERROR_MAX) {
            return true;
        }
        let columns: Vec<[f64; 6]> =
            chain.iter().map(|&joint| column(model, &posture, joint, sole.translation)).collect();
        let Some(step) = damped_step(&columns, &pose_error) else { return false };
        for (&joint, step) in chain.iter().zip(step) {
            configuration.q[joint] += step;
        }
    }
    false
}

/// A joint's column of the sole's Jacobian.
fn column(model: &RobotModel, posture: &Posture, joint: usize, sole: DVec3) -> [f64; 6] {
    let (axis, origin) = posture.joint_axis(model, joint);
    let (linear, angular) = match model.joints[joint].kind {
        JointKind::Revolute => (axis.cross(sole - origin), axis),
        JointKind::Prismatic => (axis, DVec3::ZERO),
    };
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// The damped least-squares step of the joints for `pose_error`.
fn damped_step(columns: &[[f64; 6]], pose_error: &[f64; 6]) -> Option<Vec<f64>> {
    let entry = |row: usize, other: usize| {
        columns.iter().map(|column| column[row] * column[other]).sum::<f64>()
    };
    let damped =
        |row: usize, other: usize| entry(row, other) + if row == other { IK_DAMPING } else { 0.0 };
    let matrix = (0..6).map(|row| (0..6).map(|other| damped(row, other)).collect()).collect();
    let weights = solve(matrix, pose_error.to_vec())?;
    Some(
        columns
            .iter()
            .map(|column| column.iter().zip(&weights).map(|(value, weight)| value * weight).sum())
            .collect(),
    )
}
