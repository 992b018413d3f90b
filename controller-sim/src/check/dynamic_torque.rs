//! Joint torques of a smooth motion within the effort limits, by inverse dynamics.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::segment::{Case, Violation};
use crate::check::torque::effort_excess;
use crate::kinematics::forward::{Configuration, Posture};
use crate::statics::equilibrium::Generator;
use crate::statics::inverse_dynamics::InverseDynamics;

/// Rounding allowed at a limit, as a share of the limit.
const SHARE_ROUNDING: f64 = 1e-6;

/// The smallest share of a joint's effort limit that stays unused by the contact forces that load
/// the joints least, at every waypoint and while the robot brakes; infinite for straight lines.
/// `joints` is the number of joints that a waypoint moves, `generators` are the contact forces of
/// the soles that carry. `heartbeat` is called at each instant.
///
/// # Errors
/// No contact forces within the friction pyramids move the robot so, or a joint needs more than its
/// limit.
pub fn check_dynamic_torque(
    model: &RobotModel,
    joints: usize,
    config: &CheckerConfig,
    generators: &[Generator],
    case: &Case,
    heartbeat: &mut dyn FnMut(),
) -> Result<f64, Violation> {
    let mut worst = f64::INFINITY;
    for (index, instant) in &case.instants {
        heartbeat();
        let unused = unused_share(model, joints, generators, instant, config.effort_share)
            .map_err(|detail| Violation::new(Check::DynamicTorque, *index, detail))?;
        worst = worst.min(unused);
    }
    Ok(worst)
}

fn unused_share(
    model: &RobotModel,
    joints: usize,
    generators: &[Generator],
    instant: &Waypoint,
    effort_share: f64,
) -> Result<f64, String> {
    let share_max = effort_share + SHARE_ROUNDING;
    let posture = Posture::new(model, &Configuration::of_unlocked(model, instant, joints));
    let dynamics = InverseDynamics::new(model, &posture, instant);
    let torques = dynamics
        .torques(model, &posture, generators, share_max)
        .ok_or("no contact forces within the friction move the robot so")?;
    let mut worst = f64::INFINITY;
    for (joint, torque) in model.joints.iter().zip(torques) {
        let share = torque.abs() / joint.effort;
        if !is_at_most(share, share_max) {
            return Err(effort_excess(joint, torque, effort_share));
        }
        worst = worst.min(1.0 - share);
    }
    Ok(worst)
}
