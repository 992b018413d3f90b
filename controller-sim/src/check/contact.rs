//! Stance feet: each stays at its declared pose, and the world supports it there.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::segment::{Case, Violation};
use crate::check::stance_foot::StanceFoot;
use crate::statics::sole_support::SoleSupport;

/// What remains of the position tolerance of the stance soles, m.
pub fn check_contact(
    model: &RobotModel,
    config: &CheckerConfig,
    case: &Case,
) -> Result<f64, Violation> {
    for (contact, support) in case.contacts.iter().zip(&case.supports) {
        check_support(&model.feet[contact.limb as usize].name, config, support)?;
    }
    let mut worst = f64::INFINITY;
    for (sample, feet) in case.samples_with_feet() {
        for ((contact, support), foot) in case.contacts.iter().zip(&case.supports).zip(feet) {
            let name = &model.feet[contact.limb as usize].name;
            let bad = |detail| Violation::new(Check::Contact, sample.waypoint, detail);
            worst = worst.min(pose_margin(name, config, foot).map_err(bad)?);
            check_gap(name, config, support, foot).map_err(bad)?;
        }
    }
    Ok(worst)
}

fn check_support(
    foot: &str,
    config: &CheckerConfig,
    support: &SoleSupport,
) -> Result<(), Violation> {
    let bad = |detail| Err(Violation::new(Check::Contact, 0, detail));
    if !is_at_most(support.deepest, config.contact_gap_max) {
        let (depth, limit) = (1e3 * support.deepest, 1e3 * config.contact_gap_max);
        return bad(format!(
            "the {foot} sole stands {depth:.2} mm deep in the world, limit {limit:.2} mm"
        ));
    }
    if !is_at_most(config.support_area_min, support.area) {
        let (area, limit) = (1e4 * support.area, 1e4 * config.support_area_min);
        return bad(format!(
            "the {foot} sole is supported over {area:.2} cm2 only, at least {limit:.2} cm2 are \
             needed"
        ));
    }
    Ok(())
}

fn pose_margin(name: &str, config: &CheckerConfig, foot: &StanceFoot) -> Result<f64, String> {
    if !is_at_most(foot.distance, config.foot_position_max) {
        let (distance, limit) = (1e3 * foot.distance, 1e3 * config.foot_position_max);
        return Err(format!(
            "the {name} sole is {distance:.3} mm from its declared place, limit {limit:.3} mm"
        ));
    }
    if !is_at_most(foot.turn, config.foot_rotation_max) {
        let (turn, limit) = (foot.turn.to_degrees(), config.foot_rotation_max.to_degrees());
        return Err(format!(
            "the {name} sole is turned {turn:.3} deg from its declared pose, limit {limit:.3} deg"
        ));
    }
    Ok(config.foot_position_max - foot.distance)
}

/// From the foot to the ground there is one budget: the air under the declared sole, and the
/// distance of the foot from there.
fn check_gap(
    name: &str,
    config: &CheckerConfig,
    support: &SoleSupport,
    foot: &StanceFoot,
) -> Result<(), String> {
    let gap = support.deepest.abs() + foot.displacement;
    if is_at_most(gap, config.contact_gap_max) {
        return Ok(());
    }
    let (gap, limit) = (1e3 * gap, 1e3 * config.contact_gap_max);
    Err(format!("the {name} foot may be {gap:.2} mm off the ground, limit {limit:.2} mm"))
}
