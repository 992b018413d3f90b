//! Speeds of stance soles in a smooth motion: a foot lands and leaves at rest, and does not slip.

use glam::DVec3;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::{JointKind, LimbIndex, RobotModel};

use crate::base::comparison::is_at_most;
use crate::check::segment::{Case, Violation};
use crate::check::tuning::{SOLE_SPEED_MAX, SOLE_TURN_SPEED_MAX};
use crate::kinematics::forward::{Configuration, Posture};

/// Whether each stance sole is at rest at every instant of a smooth motion.
///
/// # Errors
/// The first instant at which one moves.
pub fn check_sole_speeds(model: &RobotModel, case: &Case) -> Result<(), Violation> {
    for (index, instant) in &case.instants {
        let configuration = Configuration::of_waypoint(instant, model.joints.len());
        let posture = Posture::new(model, &configuration);
        for limb in case.stance() {
            let (speed, turn) = sole_speed(model, &posture, instant, limb);
            if is_at_most(speed, SOLE_SPEED_MAX) && is_at_most(turn, SOLE_TURN_SPEED_MAX) {
                continue;
            }
            let foot = &model.feet[limb].name;
            let detail = format!(
                "the {foot} sole moves by {speed:.3} m/s and turns by {turn:.3} rad/s while it \
                 stands, limits {SOLE_SPEED_MAX} and {SOLE_TURN_SPEED_MAX}"
            );
            return Err(Violation::new(Check::Contact, *index, detail));
        }
    }
    Ok(())
}

/// The speed (m/s) and angular speed (rad/s) of a sole: those of the root, and of each joint up to
/// the foot.
fn sole_speed(
    model: &RobotModel,
    posture: &Posture,
    instant: &Waypoint,
    limb: LimbIndex,
) -> (f64, f64) {
    let sole = posture.world_from_sole(model, limb).translation;
    let [linear, angular] = [0, 3].map(|first| DVec3::from_slice(&instant.root_velocity[first..]));
    let mut turn = angular;
    let mut velocity = linear + angular.cross(sole - posture.world_from_link[0].translation);
    for joint in model.chain(model.feet[limb].link) {
        let (axis, origin) = posture.joint_axis(model, joint);
        let rate = instant.joint_velocity[joint] * axis;
        match model.joints[joint].kind {
            JointKind::Revolute => {
                velocity += rate.cross(sole - origin);
                turn += rate;
            }
            JointKind::Prismatic => velocity += rate,
        }
    }
    (velocity.length(), turn.length())
}
