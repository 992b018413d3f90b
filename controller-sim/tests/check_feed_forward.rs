//! Feed-forward torques of motions, accepted and refused.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;
mod smooth_swing;

use check_robot::*;
use checked_motion::{check_motion, refused};
use smooth_swing::{check, smooth_swing};
use surefoot_controller_sim::{Checker, Course, MotionSegment, Stop};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

/// A motion with the torques of contact forces of least squares, as planned and at rest.
fn with_torques(
    robot: RobotModel,
    contacts: &[Contact],
    mut motion: Vec<Waypoint>,
) -> Vec<Waypoint> {
    let mut checker = Checker::new(robot, world(vec![]), CheckerConfig::default()).unwrap();
    let supports = checker.sole_supports(contacts, &motion);
    for waypoint in &mut motion {
        let torques = checker.moving_load(&supports, waypoint).torques;
        waypoint.torque[..4].copy_from_slice(&torques);
        let torques = checker.moving_load(&supports, &waypoint.rested()).torques;
        waypoint.rest_torque[..4].copy_from_slice(&torques);
    }
    motion
}

#[test]
fn feed_forward_torques_beyond_a_limit_are_refused() {
    let sound = with_torques(robot(), &both_feet(), smooth_swing(0.3, 1.0, 6));
    check(&sound, &[]).unwrap();
    for (joint, size) in [(SHOULDER, 230.0), (ELBOW, -230.0), (0, 210.0), (SHOULDER, f64::NAN)] {
        let mut motion = sound.clone();
        motion[3].torque[joint] += size;
        let violation = refused(check(&motion, &[]), Check::DynamicTorque, "is fed");
        assert_eq!(violation.waypoint, 3);
    }
    let mut motion = sound.clone();
    motion[3].rest_torque[ELBOW] = -201.0;
    refused(check(&motion, &[]), Check::DynamicTorque, "joint elbow is fed -201.00 N m");
}

#[test]
fn feed_forward_torques_that_no_contact_forces_explain_are_refused() {
    // The robot stands on its left foot.
    let mut light = robot();
    (light.links[2].mass, light.links[0].com.y) = (0.1, 0.1);
    let contacts = [contact(0)];
    let sound = with_torques(light.clone(), &contacts, smooth_swing(0.2, 1.0, 6));
    let stop = Stop { brake_at: 0.3, seconds: 0.5, resume_seconds: 0.5 };
    let mut checker = Checker::new(light, world(vec![]), CheckerConfig::default()).unwrap();
    let mut check = |waypoints: &[Waypoint], stops: &[Stop]| {
        let (mode, contacts, course) = (SupportMode::Left, &contacts, Course::Smooth(stops));
        checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || {})
    };
    check(&sound, &[stop]).unwrap();
    // What a plan of another program does not state is not compared.
    let mut motion = sound.clone();
    motion.iter_mut().for_each(|waypoint| waypoint.rest_torque = [0.0; JOINTS_MAX]);
    check(&motion, &[stop]).unwrap();
    // Of 200 N m a twentieth may differ but at the ends, where the other foot may share the load.
    let changed = |at: usize, of: fn(&mut Waypoint) -> &mut f64, size: f64| {
        let mut motion = sound.clone();
        *of(&mut motion[at]) += size;
        motion
    };
    let fields: [fn(&mut Waypoint) -> &mut f64; 4] = [
        |at| &mut at.rest_torque[SHOULDER],
        |at| &mut at.torque[SHOULDER],
        |at| &mut at.torque[0],
        |at| &mut at.torque[1],
    ];
    for of in fields {
        for size in [-11.0, 11.0] {
            let found = check(&changed(2, of, size), &[]);
            let violation = refused(found, Check::DynamicTorque, "explain the feed-forward");
            assert_eq!(violation.waypoint, 2);
            check(&changed(0, of, size), &[]).unwrap();
            check(&changed(6, of, size), &[]).unwrap();
        }
        check(&changed(2, of, 9.0), &[]).unwrap();
    }
}

#[test]
fn straight_lines_state_no_feed_forward_torques() {
    let mut motion = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    check_motion(robot(), world(vec![]), &both_feet(), &motion).unwrap();
    motion[1].torque[SHOULDER] = 1.0;
    let found = check_motion(robot(), world(vec![]), &both_feet(), &motion);
    refused(found, Check::DynamicTorque, "straight lines with feed-forward torques");
}
