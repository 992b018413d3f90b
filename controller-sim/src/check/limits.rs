//! Joint position and speed limits, and waypoints close enough together in an order of time.
//!
//! Joints move linearly between waypoints, so limits hold everywhere if they hold at the waypoints.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::{Joint, RobotModel};

use crate::base::comparison::{is_at_most, is_below};
use crate::check::checker::{Case, MotionSegment, Violation};
use crate::check::motion::Change;
use crate::kinematics::forward::Configuration;

/// Rounding allowed at a limit, rad or m.
const ROUNDING: f64 = 1e-6;

/// Proof that a segment's steps are bounded: the change over each.
pub struct Spacing {
    /// One per pair of successive waypoints.
    pub changes: Vec<Change>,
}

/// Whether time increases, every step is short, and no joint is faster than it can be.
pub fn check_spacing(
    model: &RobotModel,
    config: &CheckerConfig,
    segment: &MotionSegment,
) -> Result<Spacing, Violation> {
    let bad = |waypoint, detail: String| Err(Violation::new(Check::Spacing, waypoint, detail));
    if segment.waypoints.is_empty() {
        return bad(0, "no waypoints".into());
    }
    let mut changes = Vec::new();
    for (index, pair) in segment.waypoints.windows(2).enumerate() {
        if !is_below(pair[0].time, pair[1].time) {
            return bad(
                index,
                format!(
                    "time goes from {} s to {} s; it must increase",
                    pair[0].time, pair[1].time
                ),
            );
        }
        let [a, b] = [&pair[0], &pair[1]]
            .map(|waypoint| Configuration::of_waypoint(waypoint, model.joints.len()));
        let change = Change::between(&a, &b);
        if let Some(joint) = change
            .joints
            .iter()
            .position(|step| !is_at_most(*step, config.joint_step_max + ROUNDING))
        {
            let (name, step) = (&model.joints[joint].name, change.joints[joint]);
            return bad(
                index,
                format!(
                    "joint {name} moves {step:.4} to the next waypoint, limit {}",
                    config.joint_step_max
                ),
            );
        }
        let seconds = pair[1].time - pair[0].time;
        let is_too_fast =
            |(joint, step): (&Joint, &f64)| !is_at_most(*step, joint.velocity * seconds + ROUNDING);
        if let Some(joint) = model.joints.iter().zip(&change.joints).position(is_too_fast) {
            let (Joint { name, velocity, .. }, speed) =
                (&model.joints[joint], change.joints[joint] / seconds);
            return bad(
                index,
                format!(
                    "joint {name} moves at {speed:.2} a second to the next waypoint, limit {velocity}"
                ),
            );
        }
        if !is_at_most(change.root_position, config.root_step_max + ROUNDING) {
            return bad(
                index,
                format!(
                    "the root moves {:.4} m to the next waypoint, limit {}",
                    change.root_position, config.root_step_max
                ),
            );
        }
        if !is_at_most(change.root_rotation, config.joint_step_max + ROUNDING) {
            let turn = change.root_rotation;
            return bad(
                index,
                format!(
                    "the root turns {turn:.4} rad to the next waypoint, limit {}",
                    config.joint_step_max
                ),
            );
        }
        changes.push(change);
    }
    Ok(Spacing { changes })
}

/// The smallest distance of a joint to its limits, rad or m.
pub fn check_limits(model: &RobotModel, case: &Case) -> Result<f64, Violation> {
    let mut worst = f64::INFINITY;
    for (waypoint, configuration) in case.motion.configurations.iter().enumerate() {
        for (joint, &position) in model.joints.iter().zip(&configuration.q) {
            let margin = (position - joint.lower).min(joint.upper - position);
            if !is_at_most(-ROUNDING, margin) {
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
