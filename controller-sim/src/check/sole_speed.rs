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

#[cfg(test)]
mod tests {
    use surefoot_shared_types::base::spatial::{rotation_about, rotation_distance};

    use crate::check_robot::{robot, waypoint};

    use super::*;

    #[test]
    fn the_speed_of_a_sole_is_that_of_its_pose_in_time() {
        let mut sliding = robot();
        sliding.joints[0].kind = JointKind::Prismatic;
        sliding.joints[0].axis = DVec3::new(0.6, 0.0, 0.8);
        for model in [robot(), sliding] {
            let mut instant = waypoint(0.0, 0.0, 0.0);
            instant.root_position = [0.4, -0.3, 0.8];
            instant.root_rotation = rotation_about(DVec3::new(0.6, 0.8, 0.0), 0.7).to_array();
            instant.root_velocity = [0.3, -0.2, 0.5, 0.4, 0.9, -0.6];
            (instant.q[0], instant.q[1]) = (0.3, -0.4);
            (instant.joint_velocity[0], instant.joint_velocity[1]) = (0.7, -1.1);
            let pose_after = |seconds: f64, limb: usize| {
                let [linear, angular] =
                    [0, 3].map(|first| DVec3::from_slice(&instant.root_velocity[first..]));
                let mut later = instant;
                let rotation = glam::DQuat::from_scaled_axis(seconds * angular)
                    * glam::DQuat::from_array(instant.root_rotation);
                later.root_rotation = rotation.normalize().to_array();
                let position = DVec3::from_array(instant.root_position) + seconds * linear;
                later.root_position = position.to_array();
                for joint in 0..4 {
                    later.q[joint] += seconds * instant.joint_velocity[joint];
                }
                Posture::new(&model, &Configuration::of_waypoint(&later, 4))
                    .world_from_sole(&model, limb)
            };
            let posture = Posture::new(&model, &Configuration::of_waypoint(&instant, 4));
            for limb in [0, 1] {
                let (speed, turn) = sole_speed(&model, &posture, &instant, limb);
                let [before, after] = [-1e-4, 1e-4].map(|seconds| pose_after(seconds, limb));
                let moved = before.translation.distance(after.translation) / 2e-4;
                let turned = rotation_distance(before.rotation, after.rotation) / 2e-4;
                assert!((speed - moved).abs() < 1e-6 && (turn - turned).abs() < 1e-6);
                assert!(speed > 0.5 && turn > 0.5);
            }
        }
    }
}
