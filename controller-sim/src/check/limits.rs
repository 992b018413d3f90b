//! Joint position and speed limits, and waypoints close enough together in an order of time.
//!
//! Joints move linearly between waypoints, so limits hold everywhere if they hold at the waypoints.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::{Joint, RobotModel};

use crate::base::comparison::{is_at_most, is_below};
use crate::check::motion::{Change, Spacing};
use crate::check::segment::{Case, Violation};
use crate::kinematics::forward::Configuration;

/// Rounding allowed at a limit, rad or m.
const POSITION_ROUNDING: f64 = 1e-6;

/// The longest time between two waypoints, s. A chunk of 32 waypoints lasts at most 620 s.
const INTERVAL_MAX: f64 = 20.0;

/// Whether time increases, every step is short, and no joint is faster than its limit.
///
/// # Errors
/// The first step that violates one of these.
pub fn check_spacing(
    model: &RobotModel,
    config: &CheckerConfig,
    waypoints: &[Waypoint],
) -> Result<Spacing, Violation> {
    let bad = |waypoint, detail| Violation::new(Check::Spacing, waypoint, detail);
    if waypoints.is_empty() {
        return Err(bad(0, "no waypoints".to_owned()));
    }
    let mut changes = Vec::new();
    for (index, pair) in waypoints.windows(2).enumerate() {
        let [start, end] = [&pair[0], &pair[1]];
        check_time(start, end).map_err(|detail| bad(index, detail))?;
        let [a, b] =
            [start, end].map(|waypoint| Configuration::of_waypoint(waypoint, model.joints.len()));
        let change = Change::between(&a, &b);
        let seconds = end.time - start.time;
        check_joint_steps(model, config, &change, seconds)
            .and_then(|()| check_root_step(config, &change))
            .map_err(|detail| bad(index, detail))?;
        changes.push(change);
    }
    Ok(Spacing { changes })
}

fn check_time(start: &Waypoint, end: &Waypoint) -> Result<(), String> {
    if !is_below(start.time, end.time) {
        return Err(format!("time goes from {} s to {} s; it must increase", start.time, end.time));
    }
    let seconds = end.time - start.time;
    if !is_at_most(seconds, INTERVAL_MAX) {
        return Err(format!("the next waypoint follows after {seconds} s, limit {INTERVAL_MAX} s"));
    }
    Ok(())
}

/// Whether each joint's step is short, and slow enough for its duration of `seconds`.
fn check_joint_steps(
    model: &RobotModel,
    config: &CheckerConfig,
    change: &Change,
    seconds: f64,
) -> Result<(), String> {
    let steps = || model.joints.iter().zip(&change.joints);
    let limit = config.joint_step_max;
    if let Some((joint, step)) =
        steps().find(|(_, step)| !is_at_most(**step, limit + POSITION_ROUNDING))
    {
        let name = &joint.name;
        return Err(format!("joint {name} moves {step:.4} to the next waypoint, limit {limit}"));
    }
    let is_too_fast = |(joint, step): &(&Joint, &f64)| {
        !is_at_most(**step, joint.velocity * seconds + POSITION_ROUNDING)
    };
    if let Some((Joint { name, velocity, .. }, step)) = steps().find(is_too_fast) {
        let speed = step / seconds;
        return Err(format!(
            "joint {name} moves at {speed:.2} a second to the next waypoint, limit {velocity}"
        ));
    }
    Ok(())
}

fn check_root_step(config: &CheckerConfig, change: &Change) -> Result<(), String> {
    let (step, limit) = (change.root_position, config.root_step_max);
    if !is_at_most(step, limit + POSITION_ROUNDING) {
        return Err(format!("the root moves {step:.4} m to the next waypoint, limit {limit}"));
    }
    let (turn, limit) = (change.root_rotation, config.joint_step_max);
    if !is_at_most(turn, limit + POSITION_ROUNDING) {
        return Err(format!("the root turns {turn:.4} rad to the next waypoint, limit {limit}"));
    }
    Ok(())
}

/// Whether no joint is faster than its limit at the instants of a smooth motion. Measures no
/// margin.
///
/// # Errors
/// The first joint that is too fast.
pub fn check_speeds(model: &RobotModel, instants: &[(usize, Waypoint)]) -> Result<f64, Violation> {
    for (index, instant) in instants {
        for (joint, speed) in model.joints.iter().zip(&instant.joint_velocity) {
            let Joint { name, velocity, .. } = joint;
            if !is_at_most(speed.abs(), velocity + POSITION_ROUNDING) {
                let detail = format!("joint {name} moves at {speed:.2} a second, limit {velocity}");
                return Err(Violation::new(Check::Spacing, *index, detail));
            }
        }
    }
    Ok(f64::INFINITY)
}

/// The smallest distance of a joint to its position limits, rad or m.
///
/// # Errors
/// The first joint beyond a limit.
pub fn check_limits(model: &RobotModel, case: &Case) -> Result<f64, Violation> {
    let mut worst = f64::INFINITY;
    for (waypoint, configuration) in case.motion.configurations.iter().enumerate() {
        for (joint, &position) in model.joints.iter().zip(&configuration.q) {
            let margin = (position - joint.lower).min(joint.upper - position);
            if !is_at_most(-POSITION_ROUNDING, margin) {
                let detail = format!(
                    "joint {} at {position:.5}, limits {} to {}",
                    joint.name, joint.lower, joint.upper
                );
                return Err(Violation::new(Check::Limits, waypoint, detail));
            }
            worst = worst.min(margin);
        }
    }
    Ok(worst)
}
