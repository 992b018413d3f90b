//! Checks motions of straight lines, accepted and refused.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use surefoot_controller_sim::{Checker, Course, MotionSegment, Violation};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact, Margins, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

/// Checks a motion of straight lines on these contacts.
pub fn check_motion(
    robot: RobotModel,
    world: World,
    contacts: &[Contact],
    waypoints: &[Waypoint],
) -> Result<Margins, Violation> {
    let mode = match contacts {
        [one] if one.limb == 0 => SupportMode::Left,
        [_] => SupportMode::Right,
        _ => SupportMode::Double,
    };
    let mut checker = Checker::new(robot, world, CheckerConfig::default()).unwrap();
    checker.check_segment(
        &MotionSegment { mode, contacts, waypoints, course: Course::Straight },
        &mut || {},
    )
}

/// The violation of a refused motion: of this check, with these words.
pub fn refused(result: Result<Margins, Violation>, check: Check, words: &str) -> Violation {
    let violation = result.expect_err("must be refused");
    assert_eq!(violation.check, check, "{violation}");
    assert!(violation.detail.contains(words), "{violation}");
    violation
}
