//! Static joint torques within the effort limits.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::{Joint, RobotModel};

use crate::base::comparison::{is_at_most, largest, smallest};
use crate::check::motion::Sample;
use crate::check::segment::{Case, Violation};
use crate::check::tuning::SAMPLES_APART;
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium};
use crate::statics::joint_torques::Statics;

/// Rounding allowed at a limit, as a share of the limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// The smallest share of a joint's effort limit that stays unused, over the waypoints and the
/// samples between distant ones. `heartbeat` is called at each.
///
/// # Errors
/// No contact forces hold the robot, or a joint needs more than its limit.
pub fn check_torque(
    model: &RobotModel,
    config: &CheckerConfig,
    equilibrium: &Equilibrium,
    case: &Case,
    heartbeat: &mut dyn FnMut(),
) -> Result<f64, Violation> {
    let statics = statics_of(model, equilibrium, case);
    let share_max = config.effort_share + SHARE_ROUNDING;
    let mut worst = f64::INFINITY;
    let is_checked = |sample: &&Sample| sample.substep.is_multiple_of(SAMPLES_APART);
    for sample in case.motion.samples.iter().filter(is_checked) {
        heartbeat();
        let bad = |detail| Err(Violation::new(Check::Torque, sample.waypoint, detail));
        let torques = statics.torques(&sample.posture, sample.centre_of_mass, share_max);
        let Some(torques) = torques else {
            return bad("no contact forces in equilibrium".to_owned());
        };
        for (joint, torque) in model.joints.iter().zip(torques) {
            let share = torque.abs() / joint.effort;
            if !is_at_most(share, share_max) {
                return bad(effort_excess(joint, torque, config.effort_share));
            }
            worst = worst.min(1.0 - share);
        }
    }
    Ok(worst)
}

/// A torque beyond the share of its limit that a joint may use, in words.
pub fn effort_excess(joint: &Joint, torque: f64, effort_share: f64) -> String {
    let Joint { name, effort, .. } = joint;
    let (torque, limit, percent) = (torque.abs(), effort_share * effort, 100.0 * effort_share);
    format!(
        "joint {name} needs {torque:.2} N m or N, limit {limit:.2}, {percent:.0} % of {effort:.2}"
    )
}

/// As [`check_torque`], by contact forces of least squares instead of those that minimise the
/// largest torque share, and without a limit. Minus infinity where no such forces hold the robot.
pub fn least_squares_torque_reserve(
    model: &RobotModel,
    equilibrium: &Equilibrium,
    case: &Case,
) -> f64 {
    let statics = statics_of(model, equilibrium, case);
    let reserve = |sample: &Sample| {
        let torques = statics.least_squares_torques(&sample.posture, sample.centre_of_mass);
        let Some(torques) = torques else { return f64::NEG_INFINITY };
        let joints = model.joints.iter().zip(torques);
        1.0 - largest(joints.map(|(joint, torque)| torque.abs() / joint.effort))
    };
    smallest(case.motion.samples.iter().filter(|sample| sample.is_waypoint()).map(reserve))
}

fn statics_of<'a>(model: &'a RobotModel, equilibrium: &Equilibrium, case: &Case) -> Statics<'a> {
    Statics::new(model, equilibrium.generators(&case.supports, ALL_FRICTION), case.stance())
}
