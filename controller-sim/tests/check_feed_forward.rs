//! Feed-forward torques of motions, accepted and refused.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;
mod smooth_swing;

use check_robot::*;
use checked_motion::{check_motion, refused};
use smooth_swing::{check, smooth_swing};
use surefoot_controller_sim::{Checker, Course, MotionSegment, Stop, Violation};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, Margins, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

/// A motion with the torques of contact forces of least squares, as planned and at rest, and those
/// of a change of the rate of plan time.
fn with_torques(
    robot: RobotModel,
    contacts: &[Contact],
    mut motion: Vec<Waypoint>,
) -> Vec<Waypoint> {
    let mut checker = Checker::new(robot, world(vec![]), CheckerConfig::default()).unwrap();
    let supports = checker.sole_supports(contacts, &motion);
    for waypoint in &mut motion {
        let planned = checker.moving_load(&supports, waypoint).torques;
        waypoint.torque[..4].copy_from_slice(&planned);
        let mut changing = *waypoint;
        let speeds = changing.joint_velocity;
        changing.joint_acceleration.iter_mut().zip(speeds).for_each(|(rate, speed)| *rate += speed);
        let changed = checker.moving_load(&supports, &changing).torques;
        let by_change = changed.iter().zip(&planned).map(|(changed, planned)| changed - planned);
        waypoint.rate_change_torque.iter_mut().zip(by_change).for_each(|(slot, by)| *slot = by);
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

/// A robot that stands on its left foot alone.
fn light() -> RobotModel {
    let mut light = robot();
    (light.links[2].mass, light.links[0].com.y) = (0.1, 0.1);
    light
}

/// Checks a motion of that robot.
fn check_on_one_foot(waypoints: &[Waypoint], stops: &[Stop]) -> Result<Margins, Violation> {
    let mut checker = Checker::new(light(), world(vec![]), CheckerConfig::default()).unwrap();
    let (mode, contacts, course) = (SupportMode::Left, &[contact(0)], Course::Smooth(stops));
    checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || {})
}

const STOP: Stop = Stop { brake_at: 0.3, seconds: 0.5, resume_seconds: 0.5 };

/// The same motion with one more number added at a waypoint.
fn changed(
    sound: &[Waypoint],
    at: usize,
    of: fn(&mut Waypoint) -> &mut f64,
    size: f64,
) -> Vec<Waypoint> {
    let mut motion = sound.to_vec();
    *of(&mut motion[at]) += size;
    motion
}

#[test]
fn on_two_feet_torques_that_no_contact_forces_explain_are_refused() {
    let sound = with_torques(robot(), &both_feet(), smooth_swing(0.3, 1.0, 6));
    let fields: [fn(&mut Waypoint) -> &mut f64; 2] =
        [|at| &mut at.rest_torque[SHOULDER], |at| &mut at.torque[SHOULDER]];
    // No contact force reaches the arm. Of 200 N m 30 may differ.
    for (of, at) in fields.into_iter().flat_map(|of| [0, 3, 6].map(|at| (of, at))) {
        for size in [-31.0, 31.0] {
            let found = check(&changed(&sound, at, of, size), &[]);
            let violation = refused(found, Check::DynamicTorque, "15.5 % of its limit off");
            assert_eq!(violation.waypoint, at);
        }
        check(&changed(&sound, at, of, 29.0), &[]).unwrap();
    }
    // The hips may share the moment about y in any way: what one has more the other has less.
    let mut shared = sound.clone();
    (shared[3].torque[0], shared[3].torque[1]) =
        (shared[3].torque[0] + 40.0, shared[3].torque[1] - 40.0);
    check(&shared, &[]).unwrap();
    shared[3].torque[1] += 80.0;
    refused(check(&shared, &[]), Check::DynamicTorque, "explain the feed-forward");
}

#[test]
fn torques_at_an_end_count_unless_the_other_foot_touches_the_ground() {
    let lifted = smooth_swing(0.2, 1.0, 6).into_iter().map(|mut waypoint| {
        waypoint.q[1] = 0.4;
        waypoint
    });
    let sound = with_torques(light(), &[contact(0)], lifted.collect());
    check_on_one_foot(&sound, &[]).unwrap();
    for at in [0, 6] {
        let off = changed(&sound, at, |at| &mut at.torque[SHOULDER], 11.0);
        let found = check_on_one_foot(&off, &[]);
        let violation = refused(found, Check::DynamicTorque, "explain the feed-forward");
        assert_eq!(violation.waypoint, at);
    }
    let touching = with_torques(light(), &[contact(0)], smooth_swing(0.2, 1.0, 6));
    let fields: [fn(&mut Waypoint) -> &mut [f64; JOINTS_MAX]; 2] =
        [|at| &mut at.torque, |at| &mut at.rest_torque];
    for (of, at) in fields.into_iter().flat_map(|of| [0, 6].map(|at| (of, at))) {
        let mut ending = touching.clone();
        *of(&mut ending[at]) = [0.0; JOINTS_MAX];
        let found = check_on_one_foot(&ending, &[]);
        refused(found, Check::DynamicTorque, "end where the feet change");
    }
}

#[test]
fn torques_of_an_executed_walk_are_those_of_its_motion_or_of_a_stop() {
    let lifted = smooth_swing(0.2, 1.0, 6).into_iter().map(|mut waypoint| {
        waypoint.q[1] = 0.4;
        waypoint
    });
    let one_foot = with_torques(light(), &[contact(0)], lifted.collect());
    let two_feet = with_torques(robot(), &both_feet(), smooth_swing(0.3, 1.0, 6));
    let left = (SupportMode::Left, vec![contact(0)]);
    let double = (SupportMode::Double, both_feet().to_vec());
    // Of 200 N m of the shoulder 30 may differ on one foot, and 120 on two.
    let cases = [(light(), one_foot, left, 30.0), (robot(), two_feet, double, 120.0)];
    for (robot, sound, (mode, contacts), most) in cases {
        let mut checker = Checker::new(robot, world(vec![]), CheckerConfig::default())
            .unwrap()
            .with_stops_in_motion();
        let mut check = |size: f64| {
            let motion = changed(&sound, 3, |at| &mut at.torque[SHOULDER], size);
            let (waypoints, course) = (&motion[..], Course::Smooth(&[]));
            let segment = MotionSegment { mode, contacts: &contacts, waypoints, course };
            checker.check_segment(&segment, &mut || {})
        };
        for size in [0.0, 0.97 * most, -0.97 * most] {
            check(size).unwrap();
        }
        for size in [1.03 * most, -1.03 * most] {
            refused(check(size), Check::DynamicTorque, "explain the feed-forward");
        }
    }
}

#[test]
fn torques_of_a_change_of_the_rate_are_compared_on_one_foot_and_bounded_on_two() {
    let sound = with_torques(light(), &[contact(0)], smooth_swing(0.2, 1.0, 6));
    check_on_one_foot(&sound, &[STOP]).unwrap();
    // At a change by 4 /s 30 N m may differ.
    let of: fn(&mut Waypoint) -> &mut f64 = |at| &mut at.rate_change_torque[SHOULDER];
    for size in [-7.8, 7.8] {
        let found = check_on_one_foot(&changed(&sound, 3, of, size), &[]);
        let violation = refused(found, Check::DynamicTorque, "while it brakes");
        assert_eq!(violation.waypoint, 3);
        check_on_one_foot(&changed(&sound, 3, of, 0.9 * size), &[]).unwrap();
    }
    let sound = with_torques(robot(), &both_feet(), smooth_swing(0.3, 1.0, 6));
    let all = |size: f64| {
        let mut motion = sound.clone();
        motion.iter_mut().for_each(|waypoint| waypoint.rate_change_torque[ELBOW] = size);
        check(&motion, &[STOP])
    };
    // The rate changes by at most 1.875 / 0.5 s: by 3.75 /s.
    all(100.0).unwrap();
    refused(all(110.0), Check::DynamicTorque, "limit 400.00");
    refused(all(-110.0), Check::DynamicTorque, "joint elbow is fed");
}

#[test]
fn feed_forward_torques_that_no_contact_forces_explain_are_refused() {
    let sound = with_torques(light(), &[contact(0)], smooth_swing(0.2, 1.0, 6));
    let check = check_on_one_foot;
    check(&sound, &[STOP]).unwrap();
    // What a plan of another program does not state is not compared.
    let mut motion = sound.clone();
    motion.iter_mut().for_each(|waypoint| waypoint.rest_torque = [0.0; JOINTS_MAX]);
    check(&motion, &[STOP]).unwrap();
    // Of 200 N m a twentieth may differ but at the ends, where the other foot touches the ground.
    let fields: [fn(&mut Waypoint) -> &mut f64; 4] = [
        |at| &mut at.rest_torque[SHOULDER],
        |at| &mut at.torque[SHOULDER],
        |at| &mut at.torque[0],
        |at| &mut at.torque[1],
    ];
    for of in fields {
        for size in [-11.0, 11.0] {
            let found = check(&changed(&sound, 2, of, size), &[]);
            let violation = refused(found, Check::DynamicTorque, "explain the feed-forward");
            assert_eq!(violation.waypoint, 2);
            check(&changed(&sound, 0, of, size), &[]).unwrap();
            check(&changed(&sound, 6, of, size), &[]).unwrap();
        }
        check(&changed(&sound, 2, of, 9.0), &[]).unwrap();
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
