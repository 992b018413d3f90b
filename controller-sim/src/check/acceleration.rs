//! Joint accelerations.
//!
//! The speed of an interval is its joint displacement over its duration. A waypoint's acceleration
//! is the change of speed there over half the time of both intervals beside it. A segment must
//! begin and end at rest, because the robot stops there when a controller takes over or no further
//! segment arrives.

use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::segment::Violation;

/// What rounding of the waypoints' times may add to an acceleration, as a share of its limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// An acceleration of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakAcceleration {
    /// As a share of the joint's limit.
    pub share: f64,
    waypoint: usize,
    joint: usize,
}

/// The share of the joints' acceleration limits that stays unused at the worst waypoint. Time must
/// increase.
pub fn check_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> Result<f64, Violation> {
    let PeakAcceleration { share, waypoint, joint } = peak_acceleration(model, waypoints);
    if is_at_most(share, 1.0 + SHARE_ROUNDING) {
        return Ok(1.0 - share);
    }
    let joint = &model.joints[joint];
    let detail = format!(
        "joint {} accelerates by {:.2}, limit {}",
        joint.name,
        share * joint.acceleration,
        joint.acceleration
    );
    Err(Violation::new(Check::Acceleration, waypoint, detail))
}

/// The acceleration nearest to its limit, or furthest beyond it; one that is not a number is beyond
/// all.
pub fn peak_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> PeakAcceleration {
    let mut peak_acceleration = PeakAcceleration { share: 0.0, waypoint: 0, joint: 0 };
    for waypoint in 0..waypoints.len() {
        for (index, joint) in model.joints.iter().enumerate() {
            let share = acceleration(waypoints, waypoint, index) / joint.acceleration;
            if !is_at_most(share, peak_acceleration.share) {
                peak_acceleration = PeakAcceleration { share, waypoint, joint: index };
            }
            if share.is_nan() {
                return peak_acceleration;
            }
        }
    }
    peak_acceleration
}

/// How a joint's speed changes at a waypoint, rad/s2 or m/s2; 0 where nothing else is.
fn acceleration(waypoints: &[Waypoint], at: usize, joint: usize) -> f64 {
    let interval = |from: Option<usize>| {
        let pair = from.and_then(|from| waypoints.get(from..from + 2));
        pair.map_or((0.0, 0.0), |pair| {
            let seconds = pair[1].time - pair[0].time;
            (seconds, (pair[1].q[joint] - pair[0].q[joint]) / seconds)
        })
    };
    let (before, after) = (interval(at.checked_sub(1)), interval(Some(at)));
    let seconds = 0.5 * (before.0 + after.0);
    if seconds > 0.0 { (after.1 - before.1).abs() / seconds } else { 0.0 }
}
