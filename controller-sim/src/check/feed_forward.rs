//! Feed-forward torques of a smooth motion: those that some contact forces explain.
//!
//! A servo adds them to what it does by itself, so torques of another motion tip the robot over
//! although the motion is sound. On one foot the contact wrench is known, and with it all torques,
//! as planned and at rest. Where two feet share the load, or one begins or ends to carry alone,
//! plans hand the load over in their own ways, and only the effort limits count.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest};
use crate::check::segment::{Case, Violation};
use crate::check::tuning::FEED_FORWARD_OFF_MAX;
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::inverse_dynamics::InverseDynamics;

/// Rounding allowed at an effort limit, as a share of the limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// Whether the feed-forward torques that a motion states are within the effort limits, and on one
/// foot move the robot as planned. A motion without torques states none; one that was executed
/// (`is_executed`) has stops in it.
///
/// # Errors
/// The first instant whose torques no contact forces explain.
pub fn check_feed_forward(
    model: &RobotModel,
    case: &Case,
    is_executed: bool,
) -> Result<(), Violation> {
    let of_waypoints = case.waypoints.iter().chain(case.instants.iter().map(|(_, at)| at));
    let stated = Stated::by(of_waypoints);
    if !case.is_smooth() && (stated.moving || stated.resting) {
        let detail = "straight lines with feed-forward torques: their accelerations are not known";
        return Err(Violation::new(Check::DynamicTorque, 0, detail));
    }
    let knots = &case.instants[..case.received.len()];
    let is_received = |at: &usize| *at == 0 || knots[*at - 1].0 != knots[*at].0;
    for at in (0..knots.len()).filter(is_received) {
        let (index, instant) = &knots[at];
        let is_end = at == 0 || at + 1 == knots.len();
        let sole_foot = match *case.contacts {
            [contact] if !is_end && !is_executed => Some(contact.limb as usize),
            _ => None,
        };
        let check = |instant: &Waypoint, torques| {
            check_torques((model, sole_foot), instant, torques)
                .map_err(|detail| Violation::new(Check::DynamicTorque, *index, detail))
        };
        if stated.moving {
            check(instant, &instant.torque)?;
        }
        if stated.resting {
            check(&instant.rested(), &instant.rest_torque)?;
        }
    }
    Ok(())
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
            resting: stated.resting || states(&waypoint.rest_torque),
        })
    }
}

/// Whether these torques (N m or N) are within the limits, and, if the robot stands on one foot
/// alone, those that move it as an instant says.
fn check_torques(
    (model, sole_foot): (&RobotModel, Option<usize>),
    instant: &Waypoint,
    torques: &[f64; JOINTS_MAX],
) -> Result<(), String> {
    for (joint, torque) in model.joints.iter().zip(torques) {
        let (name, effort) = (&joint.name, joint.effort);
        if !is_at_most(torque.abs(), effort * (1.0 + SHARE_ROUNDING)) {
            return Err(format!(
                "joint {name} is fed {torque:.2} N m or N forward, limit {effort:.2}"
            ));
        }
    }
    let Some(limb) = sole_foot else { return Ok(()) };
    let posture = Posture::new(model, &Configuration::of_waypoint(instant, model.joints.len()));
    let needed = InverseDynamics::new(model, &posture, instant).torques_on(model, &posture, limb);
    let shares = model.joints.iter().zip(torques).zip(&needed);
    let off =
        largest(shares.map(|((joint, torque), needed)| (needed - torque).abs() / joint.effort));
    if is_at_most(off, FEED_FORWARD_OFF_MAX) {
        return Ok(());
    }
    let (off, most) = (1e2 * off, 1e2 * FEED_FORWARD_OFF_MAX);
    Err(format!(
        "no contact forces explain the feed-forward torques: a joint is {off:.1} % of its limit \
         off, at most {most:.0} % are possible"
    ))
}
