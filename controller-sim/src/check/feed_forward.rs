//! Feed-forward torques of a smooth motion: those that some contact forces explain.
//!
//! A servo adds them to what it does by itself, so torques of another motion tip the robot over
//! although the motion is sound. On one foot the contact wrench is known, and with it all torques:
//! as planned, at rest, and what a change of the rate of plan time adds while the robot brakes.
//! On two feet a linear program finds the contact forces that explain them best; while it brakes
//! there, torques share the load in another way, and only their size counts. Where the other foot
//! touches the ground, at the ends of a motion on one foot, it may still or already share the load;
//! the motion on two feet before or after it has the same waypoint.

use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::{Joint, RobotModel};

use crate::base::comparison::{is_at_most, largest};
use crate::check::segment::{Case, Violation};
use crate::check::tuning::{
    FEED_FORWARD_OFF_MAX, SHARED_OFF_MAX, SHARED_STOP_OFF_MAX, STOP_CHANGE, STOP_OFF_MAX,
    STOP_USE_MAX,
};
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::equilibrium::Generator;
use crate::statics::inverse_dynamics::InverseDynamics;

/// Rounding allowed at an effort limit, as a share of the limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// What a motion stands on: contact forces of these generators, and whether the other foot touches
/// the world at a waypoint as well.
pub(crate) struct Carriers<'a> {
    pub(crate) generators: &'a [Generator],
    pub(crate) touches: &'a dyn Fn(&Waypoint) -> bool,
}

/// Whether the feed-forward torques that a motion states are within the effort limits, and some
/// contact forces move the robot as planned with them. A motion without torques states none; one
/// that was executed (`is_executed`) has stops in it, and stands anywhere between two motions.
///
/// # Errors
/// The first instant whose torques no contact forces explain.
pub(crate) fn check_feed_forward(
    model: &RobotModel,
    carriers: &Carriers,
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
    let is_received = |at: &usize| *at == 0 || knots[*at - 1].0 != knots[*at].0;
    for at in (0..knots.len()).filter(is_received) {
        let (index, instant) = &knots[at];
        let is_end = at == 0 || at + 1 == knots.len();
        let may_hand_over = (is_end || is_executed) && stance.len() == 1;
        let checked = if may_hand_over && (carriers.touches)(instant) {
            check_sizes(model, instant).and_then(|()| stated.check_at(instant))
        } else {
            let generators = carriers.generators;
            StandingFeet { model, generators, stance: &stance, is_executed }.check(instant, &stated)
        };
        checked.map_err(|detail| Violation::new(Check::DynamicTorque, *index, detail))?;
    }
    stops.iter().try_for_each(|(index, instant)| {
        check_size(model, &instant.torque, STOP_USE_MAX)
            .map_err(|detail| Violation::new(Check::DynamicTorque, *index, detail))
    })
}

/// Whether the forces of one foot explain the torques of an instant at which the robot goes on, on
/// the same foot: there nothing is handed over, although the other foot may touch the ground.
///
/// # Errors
/// They do not.
pub(crate) fn check_going_on(
    model: &RobotModel,
    stance: &[usize],
    generators: &[Generator],
    instant: &Waypoint,
) -> Result<(), Violation> {
    StandingFeet { model, generators, stance, is_executed: false }
        .check(instant, &Stated::by([instant].into_iter()))
        .map_err(|detail| Violation::new(Check::DynamicTorque, 0, detail))
}

/// What a motion states somewhere.
struct Stated {
    moving: bool,
    resting: bool,
    changing: bool,
}

impl Stated {
    fn by<'a>(waypoints: impl Iterator<Item = &'a Waypoint>) -> Self {
        let nothing = Self { moving: false, resting: false, changing: false };
        waypoints.fold(nothing, |stated, waypoint| Self {
            moving: stated.moving || states(&waypoint.torque),
            resting: stated.resting || states(&waypoint.rest_torque),
            changing: stated.changing || states(&waypoint.rate_change_torque),
        })
    }

    /// Whether an instant states what the motion states elsewhere, so that the motion before or
    /// after it, which has this instant too, states it.
    fn check_at(&self, instant: &Waypoint) -> Result<(), String> {
        let is_left_out = (self.moving && !states(&instant.torque))
            || (self.resting && !states(&instant.rest_torque));
        if is_left_out {
            return Err("the feed-forward torques end where the feet change".to_owned());
        }
        Ok(())
    }
}

fn states(torques: &[f64; JOINTS_MAX]) -> bool {
    torques.iter().any(|torque| *torque != 0.0)
}

/// Whether the torques of an instant, as planned and at rest, are within the limits.
fn check_sizes(model: &RobotModel, instant: &Waypoint) -> Result<(), String> {
    check_size(model, &instant.torque, 1.0)?;
    check_size(model, &instant.rest_torque, 1.0)
}

/// Whether torques (N m or N) are at most this share of the limits.
fn check_size(
    model: &RobotModel,
    torques: &[f64; JOINTS_MAX],
    share_max: f64,
) -> Result<(), String> {
    for (joint, torque) in model.joints.iter().zip(torques) {
        let (name, limit) = (&joint.name, share_max * joint.effort);
        if !is_at_most(torque.abs(), limit * (1.0 + SHARE_ROUNDING)) {
            return Err(format!(
                "joint {name} is fed {torque:.2} N m or N forward, limit {limit:.2}"
            ));
        }
    }
    Ok(())
}

/// A robot on its stance feet.
struct StandingFeet<'a> {
    model: &'a RobotModel,
    generators: &'a [Generator],
    stance: &'a [usize],
    /// Whether the robot may be in a stop.
    is_executed: bool,
}

impl StandingFeet<'_> {
    /// Whether some contact forces explain the torques that an instant states. On one foot those
    /// of a change of the rate of plan time are known, too.
    fn check(&self, instant: &Waypoint, stated: &Stated) -> Result<(), String> {
        check_sizes(self.model, instant)?;
        let is_on_one_foot = self.stance.len() == 1;
        let off_max = match (is_on_one_foot, self.is_executed) {
            (true, false) => FEED_FORWARD_OFF_MAX,
            (true, true) => STOP_OFF_MAX,
            (false, false) => SHARED_OFF_MAX,
            (false, true) => SHARED_STOP_OFF_MAX,
        };
        if stated.moving {
            self.check_torques(instant, &instant.torque, off_max)?;
        }
        if stated.resting {
            self.check_torques(&instant.rested(), &instant.rest_torque, off_max)?;
        }
        if stated.moving && stated.changing && is_on_one_foot && !self.is_executed {
            let mut braking = *instant;
            let rates = braking.root_acceleration.iter_mut().zip(&instant.root_velocity);
            let joints = braking.joint_acceleration.iter_mut().zip(&instant.joint_velocity);
            rates.chain(joints).for_each(|(rate, speed)| *rate += STOP_CHANGE * speed);
            let by_change = braking.torque.iter_mut().zip(&instant.rate_change_torque);
            by_change.for_each(|(torque, change)| *torque += STOP_CHANGE * change);
            self.check_torques(&braking, &braking.torque, STOP_OFF_MAX)
                .map_err(|detail| format!("while it brakes: {detail}"))?;
        }
        Ok(())
    }

    /// Whether some contact forces move the robot as an instant says if its joints exert these
    /// torques (N m or N), each off by at most `off_max` of its limit.
    fn check_torques(
        &self,
        instant: &Waypoint,
        torques: &[f64; JOINTS_MAX],
        off_max: f64,
    ) -> Result<(), String> {
        let Self { model, generators, stance, .. } = *self;
        let posture = Posture::new(model, &Configuration::of_waypoint(instant, model.joints.len()));
        let dynamics = InverseDynamics::new(model, &posture, instant).less(torques);
        let missing = match *stance {
            [limb] => dynamics.torques_on(model, &posture, limb),
            _ => dynamics
                .torques(model, &posture, generators, off_max)
                .ok_or("no contact forces within the friction move the robot so")?,
        };
        let share = |(off, joint): (&f64, &Joint)| off.abs() / joint.effort;
        let shares = missing.iter().zip(&model.joints).map(share);
        let off = largest(shares.clone());
        if is_at_most(off, off_max) {
            return Ok(());
        }
        let named = model.joints.iter().zip(shares).find(|(_, share)| *share == off);
        let name = named.map_or("", |(joint, _)| &joint.name);
        let (off, most) = (1e2 * off, 1e2 * off_max);
        Err(format!(
            "no contact forces explain the feed-forward torques: joint {name} is {off:.1} % of \
             its limit off, at most {most:.0} % are possible"
        ))
    }
}
