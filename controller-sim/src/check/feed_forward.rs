//! Feed-forward torques of a smooth motion: those that some contact forces explain.
//!
//! A servo adds them to what it does by itself, so torques of another motion tip the robot over
//! although the motion is sound. They are compared with the plan's motion at the received
//! waypoints, as it is planned and at rest there, and on one foot while the robot brakes and goes
//! on. Where one foot begins or ends to carry alone, the other one may still take a part of the
//! load. On two feet a stop shares the load in another way than its torques, which depend on the
//! change of the rate of plan time linearly, and is not compared.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest};
use crate::check::segment::{Case, Violation};
use crate::check::tuning::{FEED_FORWARD_OFF_MAX, SHARED_FEED_FORWARD_OFF_MAX};
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::equilibrium::Generator;
use crate::statics::inverse_dynamics::InverseDynamics;

/// Rounding allowed at an effort limit, as a share of the limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// Whether the feed-forward torques that a motion states are within the effort limits, and move the
/// robot as planned under contact forces of these `generators`. A motion without torques states
/// none; one that was executed (`is_executed`) has stops in it.
///
/// # Errors
/// The first instant whose torques no contact forces explain.
pub fn check_feed_forward(
    model: &RobotModel,
    generators: &[Generator],
    case: &Case,
    is_executed: bool,
) -> Result<(), Violation> {
    let of_waypoints = case.waypoints.iter().chain(case.instants.iter().map(|(_, at)| at));
    let stated = Stated::by(of_waypoints);
    if !case.is_smooth() && (stated.moving || stated.resting) {
        let detail = "straight lines with feed-forward torques: their accelerations are not known";
        return Err(Violation::new(Check::DynamicTorque, 0, detail));
    }
    let (knots, stops) = case.instants.split_at(case.received.len());
    let stance = case.stance();
    let is_on_one_foot = stance.len() == 1;
    let check = |index: usize, instant: &Waypoint, torques: &[f64; JOINTS_MAX], off_max: f64| {
        check_torques((model, generators, &stance), instant, torques, off_max)
            .map_err(|detail| Violation::new(Check::DynamicTorque, index, detail))
    };
    let is_received = |at: &usize| *at == 0 || knots[*at - 1].0 != knots[*at].0;
    for at in (0..knots.len()).filter(is_received) {
        let (index, instant) = &knots[at];
        let is_end = at == 0 || at + 1 == knots.len();
        let is_shared = !is_on_one_foot || is_end || is_executed;
        let off_max = if is_shared { SHARED_FEED_FORWARD_OFF_MAX } else { FEED_FORWARD_OFF_MAX };
        if stated.moving {
            check(*index, instant, &instant.torque, off_max)?;
        }
        if stated.resting {
            check(*index, &instant.rested(), &instant.rest_torque, off_max)?;
        }
    }
    let stops = stops.iter().filter(|_| stated.resting && is_on_one_foot);
    stops.into_iter().try_for_each(|(index, instant)| {
        check(*index, instant, &instant.torque, SHARED_FEED_FORWARD_OFF_MAX)
    })
}

/// What a motion states somewhere.
struct Stated {
    moving: bool,
    resting: bool,
}

impl Stated {
    fn by<'a>(waypoints: impl Iterator<Item = &'a Waypoint>) -> Self {
        let states = |torques: &[f64; JOINTS_MAX]| torques.iter().any(|torque| *torque != 0.0);
        waypoints.fold(Self { moving: false, resting: false }, |stated, waypoint| Self {
            moving: stated.moving || states(&waypoint.torque),
            resting: stated.resting
                || states(&waypoint.rest_torque)
                || states(&waypoint.rate_change_torque),
        })
    }
}

/// Whether some contact forces move the robot as an instant says if its joints exert these torques
/// (N m or N), each off by at most `off_max` of its limit.
fn check_torques(
    (model, generators, stance): (&RobotModel, &[Generator], &[usize]),
    instant: &Waypoint,
    torques: &[f64; JOINTS_MAX],
    off_max: f64,
) -> Result<(), String> {
    for (joint, torque) in model.joints.iter().zip(torques) {
        let (name, effort) = (&joint.name, joint.effort);
        if !is_at_most(torque.abs(), effort * (1.0 + SHARE_ROUNDING)) {
            return Err(format!(
                "joint {name} is fed {torque:.2} N m or N forward, limit {effort:.2}"
            ));
        }
    }
    let posture = Posture::new(model, &Configuration::of_waypoint(instant, model.joints.len()));
    let dynamics = InverseDynamics::new(model, &posture, instant).less(torques);
    let missing = match *stance {
        [limb] => dynamics.torques_on(model, &posture, limb),
        _ => dynamics
            .torques(model, &posture, generators, off_max)
            .ok_or("no contact forces within the friction move the robot so")?,
    };
    let shares = missing.iter().zip(&model.joints).map(|(off, joint)| off.abs() / joint.effort);
    let off = largest(shares);
    if is_at_most(off, off_max) {
        return Ok(());
    }
    let (off, most) = (1e2 * off, 1e2 * off_max);
    Err(format!(
        "no contact forces explain the feed-forward torques: a joint is {off:.1} % of its limit \
         off, at most {most:.0} % are possible"
    ))
}
