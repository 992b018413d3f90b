//! How a leg reaches a sole that is a little elsewhere than its configuration puts it: Newton's
//! method on the joints that carry its foot and no other, damped where the leg is nearly straight.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::{JointKind, LimbIndex, RobotModel};
use surefoot_shared_types::spatial::scaled_axis_from_rotation;

use crate::check::least_squares::solve;
use crate::kinematics::{Configuration, Posture};

/// Newton steps; a millimetre takes three or four.
const STEPS_MAX: usize = 20;
/// The sole is where it should be within this, m and rad.
const REACHED: f64 = 1e-10;
/// Added to the normal equations' diagonal.
const DAMPING: f64 = 1e-9;

/// Moves the joints of one leg until its sole is at `world_from_sole`. False if it is not reached;
/// joint limits are the caller's to check.
pub fn reach(
    model: &RobotModel,
    configuration: &mut Configuration,
    limb: LimbIndex,
    world_from_sole: &Pose,
) -> bool {
    let chain = model.leg(limb);
    for _ in 0..STEPS_MAX {
        let posture = Posture::new(model, configuration);
        let sole = posture.world_from_sole(model, limb);
        let way = world_from_sole.translation - sole.translation;
        let turn = scaled_axis_from_rotation(world_from_sole.rotation * sole.rotation.conjugate());
        let missed = [way.x, way.y, way.z, turn.x, turn.y, turn.z];
        if missed.iter().all(|value| value.abs() <= REACHED) {
            return true;
        }
        let columns: Vec<[f64; 6]> =
            chain.iter().map(|&joint| column(model, &posture, joint, sole.translation)).collect();
        let Some(step) = least_step(&columns, &missed) else { return false };
        for (&joint, step) in chain.iter().zip(step) {
            configuration.q[joint] += step;
        }
    }
    false
}

/// How the sole moves and turns when a joint does.
fn column(model: &RobotModel, posture: &Posture, joint: usize, sole: DVec3) -> [f64; 6] {
    let (axis, origin) = posture.joint_axis(model, joint);
    let (way, turn) = match model.joints[joint].kind {
        JointKind::Revolute => (axis.cross(sole - origin), axis),
        JointKind::Prismatic => (axis, DVec3::ZERO),
    };
    [way.x, way.y, way.z, turn.x, turn.y, turn.z]
}

/// The shortest step of the joints that makes up for `missed`.
fn least_step(columns: &[[f64; 6]], missed: &[f64; 6]) -> Option<Vec<f64>> {
    let entry = |row: usize, other: usize| {
        columns.iter().map(|column| column[row] * column[other]).sum::<f64>()
    };
    let damped =
        |row: usize, other: usize| entry(row, other) + if row == other { DAMPING } else { 0.0 };
    let matrix = (0..6).map(|row| (0..6).map(|other| damped(row, other)).collect()).collect();
    let weights = solve(matrix, missed.to_vec())?;
    Some(
        columns
            .iter()
            .map(|column| column.iter().zip(&weights).map(|(value, weight)| value * weight).sum())
            .collect(),
    )
}
