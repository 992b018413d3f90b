//! Limits, spacing and acceleration of a motion against cases computed by hand, and which checks
//! run on what.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use surefoot_controller_sim::{Checker, CheckerError, Course, MotionSegment};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, SupportMode, Waypoint};

#[test]
fn a_joint_past_its_limit_is_named() {
    let waypoints = swing((2.3, 0.0), (2.51, 0.0), 3);
    let violation = refused(
        check_motion(robot(), world(vec![]), &both_feet(), &waypoints),
        Check::Limits,
        "shoulder",
    );
    assert_eq!(violation.waypoint, 2);
}

#[test]
fn jumps_and_stopped_clocks_are_refused() {
    let jump = swing((0.0, 0.0), (0.21, 0.0), 2);
    refused(check_motion(robot(), world(vec![]), &both_feet(), &jump), Check::Spacing, "shoulder");
    let mut stopped = swing((0.0, 0.0), (0.1, 0.0), 3);
    stopped[2].time = stopped[1].time;
    assert_eq!(
        refused(
            check_motion(robot(), world(vec![]), &both_feet(), &stopped),
            Check::Spacing,
            "time"
        )
        .waypoint,
        1
    );
    let mut slide = swing((0.0, 0.0), (0.1, 0.0), 2);
    slide[1].root_position[0] = 1e6;
    refused(check_motion(robot(), world(vec![]), &both_feet(), &slide), Check::Spacing, "root");
}

#[test]
fn check_all_names_every_violated_check() {
    let mut weak = robot();
    weak.joints[SHOULDER].effort = 1.0;
    let mut checker = Checker::new(weak, world(vec![]), CheckerConfig::default()).unwrap();
    let waypoints = swing((0.9, 0.0), (0.9, -1.5), 11);
    let report = checker.check_all(&MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &waypoints,
        course: Course::Straight,
    });
    let found: Vec<Check> = report.violations.iter().map(|violation| violation.check).collect();
    assert_eq!(found, [Check::Torque]);
    assert!(report.margins.balance.is_finite() && report.margins.torque == f64::INFINITY);
}

#[test]
fn nan_passes_no_check() {
    let standing = |spoil: fn(&mut Waypoint)| {
        let mut waypoint = waypoint(0.0, 0.0, 0.0);
        spoil(&mut waypoint);
        check_motion(robot(), world(vec![]), &both_feet(), &[waypoint])
    };
    refused(standing(|waypoint| waypoint.q[SHOULDER] = f64::NAN), Check::Limits, "shoulder");
    refused(standing(|waypoint| waypoint.root_position[2] = f64::NAN), Check::Contact, "left sole");
    refused(
        standing(|waypoint| waypoint.root_rotation = [f64::NAN; 4]),
        Check::Contact,
        "left sole",
    );
    let mut swing = swing((0.0, 0.0), (0.1, 0.0), 3);
    swing[1].time = f64::NAN;
    refused(check_motion(robot(), world(vec![]), &both_feet(), &swing), Check::Spacing, "time");
    let mut contacts = both_feet();
    contacts[1].position[0] = f64::NAN;
    refused(
        check_motion(robot(), world(vec![]), &contacts, &[waypoint(0.0, 0.0, 0.0)]),
        Check::Contact,
        "right sole",
    );
}

#[test]
fn links_with_a_nan_pose_collide() {
    let mut lost = waypoint(0.0, 0.0, 0.0);
    lost.q[SHOULDER] = f64::NAN;
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let report = checker.check_all(&MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &[lost],
        course: Course::Straight,
    });
    let checks: Vec<Check> = report.violations.iter().map(|violation| violation.check).collect();
    assert!(
        checks.contains(&Check::Collision) && checks.contains(&Check::SelfCollision),
        "{:?}",
        report.violations
    );
}

#[test]
fn a_check_calls_the_heartbeat_at_every_waypoint() {
    let waypoints = swing((0.0, 0.0), (0.3, 0.0), 8);
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let mut signs = 0;
    let segment = MotionSegment {
        mode: SupportMode::Double,
        contacts: &both_feet(),
        waypoints: &waypoints,
        course: Course::Straight,
    };
    checker.check_segment(&segment, &mut || signs += 1).unwrap();
    // Torque, collision and self-collision.
    assert!(signs >= 3 * waypoints.len(), "{signs}");
}

#[test]
fn robots_that_cannot_be_checked_are_refused() {
    let mut one_legged = robot();
    one_legged.feet.pop();
    assert!(matches!(
        Checker::new(one_legged, world(vec![]), CheckerConfig::default()),
        Err(CheckerError::NotABiped { feet: 1 })
    ));
    let mut giant = robot();
    giant.feet[0].polygon[0].x = -0.11;
    assert!(matches!(
        Checker::new(giant, world(vec![]), CheckerConfig::default()),
        Err(CheckerError::SoleOffFoot { .. })
    ));
}

#[test]
fn starts_stops_and_turns_are_accelerations() {
    let mut checker = Checker::new(robot(), world(vec![]), CheckerConfig::default()).unwrap();
    let mut unused = |waypoints: &[Waypoint]| {
        checker
            .check_all(&MotionSegment {
                mode: SupportMode::Double,
                contacts: &both_feet(),
                waypoints,
                course: Course::Straight,
            })
            .acceleration
    };
    // From rest to rest over 0.1 rad within a second takes 0.4 rad/s2, of a limit of 10 rad/s2.
    let needs = |unused: f64, share: f64| ((1.0 - unused) / share - 1.0).abs() < 0.02;
    assert!(needs(unused(&[waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.1, 0.0)]), 0.04));
    // There and back over 12.5 mrad, 0.1 s each way, takes 5 rad/s2.
    let turn = [waypoint(0.0, 0.0, 0.0), waypoint(0.1, 0.0125, 0.0), waypoint(0.2, 0.0, 0.0)];
    assert!(needs(unused(&turn), 0.5));
    // A wait before and one after a move give it no more than the travel back, 1 mrad each.
    let wait = [
        waypoint(0.0, 0.0, 0.0),
        waypoint(2.0, 0.0, 0.0),
        waypoint(2.1, 0.0125, 0.0),
        waypoint(4.1, 0.0125, 0.0),
    ];
    let share = 1.0 - unused(&wait);
    assert!(share > 0.2 && share < 0.505, "{share}");
    assert_eq!(unused(&[waypoint(0.0, 0.3, 0.0)]), 1.0);
    // Half the time is four times the acceleration.
    let quicker = turn.map(|waypoint| Waypoint { time: 0.5 * waypoint.time, ..waypoint });
    refused(
        check_motion(robot(), world(vec![]), &both_feet(), &quicker),
        Check::Acceleration,
        "joint shoulder has to accelerate by 20",
    );
}

#[test]
fn a_motion_that_does_not_stop_at_its_end_is_refused() {
    // Gently up to 1.4 rad/s, and then no further waypoint.
    let times_and_angles = [(0.0, 0.0), (0.4, 0.1), (0.6, 0.2), (0.75, 0.29), (0.8, 0.36)];
    let waypoints = times_and_angles.map(|(time, shoulder)| waypoint(time, shoulder, 0.0));
    let violation = refused(
        check_motion(robot(), world(vec![]), &both_feet(), &waypoints),
        Check::Acceleration,
        "shoulder",
    );
    assert_eq!(violation.waypoint, 4);
    let whole = check_motion(
        robot(),
        world(vec![]),
        &both_feet(),
        &[&waypoints[..], &[waypoint(1.2, 0.45, 0.0)]].concat(),
    );
    assert!(whole.is_ok(), "{whole:?}");
}
