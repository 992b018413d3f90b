//! Joint accelerations.
//!
//! A smooth motion states its accelerations; they are compared with the limits that the robot file
//! states. In straight lines the speed jumps at waypoints. There the least acceleration counts with
//! which a joint can be at every waypoint in time, at rest at the first and the last one, with a
//! continuous speed: the robot stops at a segment's end when a controller takes over or no further
//! segment arrives.
//!
//! A joint that goes from speed `u` to speed `w` within `t`, and a way `d` meanwhile, with
//! accelerations up to `a`, exists if and only if
//! `|d - (u + w) t / 2| + (w - u)^2 / (4 a) <= a t^2 / 4`. The speeds `w` that can be reached from
//! an interval of speeds `u` are an interval, which is followed from waypoint to waypoint.

use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::{ACCELERATION_DEFAULT, RobotModel};

use crate::base::comparison::is_at_most;
use crate::check::segment::Violation;

/// What rounding may add to an acceleration, as a share of its limit.
const SHARE_ROUNDING: f64 = 1e-6;
/// Shares of a limit are measured to this ratio.
const SHARE_RATIO: f64 = 1.01;
/// A speed (rad/s or m/s) that rounding leaves of rest.
const REST_ROUNDING: f64 = 1e-9;
/// Larger shares of a limit count as this one.
const SHARE_MAX: f64 = 1e9;

/// An acceleration of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakAcceleration {
    /// As a share of the joint's limit, rounded up.
    pub share: f64,
    joint: usize,
}

/// The share of the joints' acceleration limits that stays unused by straight lines. Time must
/// increase.
///
/// # Errors
/// A joint needs more than its limit.
pub fn check_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> Result<f64, Violation> {
    let PeakAcceleration { share, joint: index } = peak_acceleration(model, waypoints);
    if is_at_most(share, 1.0 + SHARE_ROUNDING) {
        return Ok(1.0 - share);
    }
    let joint = &model.joints[index];
    let (name, limit) = (&joint.name, joint.acceleration);
    let needed = share * limit;
    let detail = format!("joint {name} has to accelerate by {needed:.2}, limit {limit}");
    let waypoint = first_unreachable(waypoints, index, limit).unwrap_or(0);
    Err(Violation::new(Check::Acceleration, waypoint, detail))
}

/// As [`check_acceleration`] for a smooth motion. A limit that the robot file does not state is
/// none; torques bound the acceleration of such a joint.
///
/// # Errors
/// A joint needs more than its limit.
pub fn check_stated_accelerations(
    model: &RobotModel,
    instants: &[(usize, Waypoint)],
) -> Result<f64, Violation> {
    let mut worst = f64::INFINITY;
    for (index, instant) in instants {
        for (joint, acceleration) in model.joints.iter().zip(&instant.joint_acceleration) {
            let limit = joint.acceleration;
            if limit == ACCELERATION_DEFAULT {
                continue;
            }
            let share = acceleration.abs() / limit;
            if !is_at_most(share, 1.0 + SHARE_ROUNDING) {
                let name = &joint.name;
                let detail =
                    format!("joint {name} accelerates by {acceleration:.2}, limit {limit}");
                return Err(Violation::new(Check::Acceleration, *index, detail));
            }
            worst = worst.min(1.0 - share);
        }
    }
    Ok(worst)
}

/// The acceleration nearest to its limit, or furthest beyond it.
pub fn peak_acceleration(model: &RobotModel, waypoints: &[Waypoint]) -> PeakAcceleration {
    let mut peak = PeakAcceleration { share: 0.0, joint: 0 };
    for (index, joint) in model.joints.iter().enumerate() {
        let is_enough =
            |share: f64| first_unreachable(waypoints, index, share * joint.acceleration).is_none();
        if peak.share > 0.0 && is_enough(peak.share) {
            continue;
        }
        peak = PeakAcceleration { share: least_share(is_enough), joint: index };
    }
    peak
}

/// The least share of a limit that is enough, rounded up by [`SHARE_RATIO`]; 0 where nothing moves.
fn least_share(is_enough: impl Fn(f64) -> bool) -> f64 {
    const SHARE_MIN: f64 = 1e-3;
    if is_enough(0.0) {
        return 0.0;
    }
    let (mut too_little, mut enough) = (0.0, SHARE_MIN);
    while !is_enough(enough) {
        (too_little, enough) = (enough, 2.0 * enough);
        if enough > SHARE_MAX {
            return SHARE_MAX;
        }
    }
    // The limit itself decides between acceptance and refusal, so it is tried exactly.
    if too_little < 1.0 && enough > 1.0 {
        if is_enough(1.0) { enough = 1.0 } else { too_little = 1.0 }
    }
    while enough > SHARE_RATIO * too_little && enough > SHARE_MIN {
        let middle = 0.5 * (too_little + enough);
        if is_enough(middle) { enough = middle } else { too_little = middle }
    }
    enough
}

/// The first waypoint at which a joint cannot be in time with accelerations up to `limit`, or the
/// last one if it cannot be at rest there. No number is reachable that is none.
fn first_unreachable(waypoints: &[Waypoint], joint: usize, limit: f64) -> Option<usize> {
    let mut speeds = (0.0, 0.0);
    for (index, pair) in waypoints.windows(2).enumerate() {
        let seconds = pair[1].time - pair[0].time;
        let way = pair[1].q[joint] - pair[0].q[joint];
        match speeds_after(speeds, way, seconds, limit) {
            Some(after) => speeds = after,
            None => return Some(index + 1),
        }
    }
    let rests = is_at_most(speeds.0, REST_ROUNDING) && is_at_most(-REST_ROUNDING, speeds.1);
    (!rests).then(|| waypoints.len().saturating_sub(1))
}

/// The speeds that can be reached after `way` within `seconds` from one of the speeds between
/// `least` and `most`.
fn speeds_after(
    (least, most): (f64, f64),
    way: f64,
    seconds: f64,
    limit: f64,
) -> Option<(f64, f64)> {
    let highest = highest_speed(least, most, way, seconds, limit)?;
    let lowest = -highest_speed(-most, -least, -way, seconds, limit)?;
    Some((lowest, highest))
}

/// The highest of these speeds. It is highest after full acceleration from the speed
/// `way / seconds - limit * seconds / 2`, else from the nearest speed above.
fn highest_speed(least: f64, most: f64, way: f64, seconds: f64, limit: f64) -> Option<f64> {
    // A joint that stands, and may not accelerate, is at rest in spite of rounding.
    let slack = 1e-12 * (1.0 + limit * seconds);
    let best = way / seconds - 0.5 * limit * seconds;
    if !is_at_most(best, most + slack) {
        return None;
    }
    if is_at_most(least, best) {
        return Some(best + limit * seconds);
    }
    // From `least` the joint first slows down, then speeds up.
    let room = 2.0 * limit * limit * seconds * seconds + 4.0 * limit * (way - least * seconds);
    let is_possible = is_at_most(-slack * limit * seconds, room);
    is_possible.then(|| least - limit * seconds + room.max(0.0).sqrt())
}
