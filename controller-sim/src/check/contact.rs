//! Stance feet: each stays at its declared pose, and the world supports it there.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest, smallest};
use crate::check::segment::{Case, Violation};
use crate::check::stance_foot::StanceFoot;
use crate::check::tuning::LANDING_HEIGHT_MAX;
use crate::statics::sole_support::SoleSupport;

/// What remains of the position tolerance of the stance soles, m.
pub fn check_contact(
    model: &RobotModel,
    config: &CheckerConfig,
    case: &Case,
) -> Result<f64, Violation> {
    for (contact, support) in case.contacts.iter().zip(&case.supports) {
        let name = &model.feet[contact.limb as usize].name;
        check_support(name, config, support)?;
        if case.is_smooth() {
            check_landing(name, support)?;
        }
    }
    if case.is_smooth() {
        check_level(&case.supports)?;
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

/// The motion of a smooth plan has no time for a foot that meets the ground early or late.
fn check_landing(foot: &str, support: &SoleSupport) -> Result<(), Violation> {
    if is_at_most(support.deepest.abs(), LANDING_HEIGHT_MAX) {
        return Ok(());
    }
    let (off, limit) = (1e3 * support.deepest.abs(), 1e3 * LANDING_HEIGHT_MAX);
    let side = if support.deepest > 0.0 { "in" } else { "over" };
    let detail = format!(
        "the {foot} sole of a smooth motion is declared {off:.2} mm {side} the ground, limit \
         {limit:.2} mm"
    );
    Err(Violation::new(Check::Contact, 0, detail))
}

/// A robot sinks onto the foot that carries it, and the other one meets the ground early or late
/// by the difference of their heights over it.
fn check_level(supports: &[SoleSupport]) -> Result<(), Violation> {
    let depths = || supports.iter().map(|support| support.deepest);
    let least = smallest(depths());
    let apart = largest(depths().map(|depth| depth - least));
    if is_at_most(apart, LANDING_HEIGHT_MAX) {
        return Ok(());
    }
    let (apart, limit) = (1e3 * apart, 1e3 * LANDING_HEIGHT_MAX);
    let detail = format!(
        "the soles of a smooth motion are declared {apart:.2} mm more and less deep in the ground, \
         limit {limit:.2} mm"
    );
    Err(Violation::new(Check::Contact, 0, detail))
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
