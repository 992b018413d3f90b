//! An arm that swings along polynomials of degree 5, and the checks of such motions.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use surefoot_controller_sim::{Checker, Course, MotionSegment, Stop, Violation};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Margins, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::check_robot::*;

/// The arm swings by `angle` from rest to rest within `seconds`, along
/// `10 s^3 - 15 s^4 + 6 s^5`, with waypoints in `count` intervals.
pub fn smooth_swing(angle: f64, seconds: f64, count: usize) -> Vec<Waypoint> {
    let at = |index: usize| {
        let s = index as f64 / count as f64;
        let risen = s * s * s * (10.0 - s * (15.0 - 6.0 * s));
        let mut waypoint = waypoint(s * seconds, angle * risen, 0.0);
        let slope = 30.0 * s * s * (1.0 - s) * (1.0 - s);
        let bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
        waypoint.joint_velocity[SHOULDER] = angle * slope / seconds;
        waypoint.joint_acceleration[SHOULDER] = angle * bend / (seconds * seconds);
        waypoint
    };
    (0..=count).map(at).collect()
}

/// Checks a smooth motion on both feet.
pub fn check_with(
    robot: RobotModel,
    world: World,
    waypoints: &[Waypoint],
    stops: &[Stop],
) -> Result<Margins, Violation> {
    let mut checker = Checker::new(robot, world, CheckerConfig::default()).unwrap();
    let (mode, contacts) = (SupportMode::Double, &both_feet());
    let course = Course::Smooth(stops);
    checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || {})
}

/// The same of the robot of the tests, on a bare floor.
pub fn check(waypoints: &[Waypoint], stops: &[Stop]) -> Result<Margins, Violation> {
    check_with(robot(), world(vec![]), waypoints, stops)
}
