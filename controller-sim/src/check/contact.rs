//! Stance feet: each stays at its declared pose, and the world supports it there.

use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::is_at_most;
use crate::check::motion::Sample;
use crate::check::segment::{Case, Violation};
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
    for sample in &case.motion.samples {
        for contact in case.contacts {
            worst = worst.min(pose_margin(model, config, contact, sample)?);
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
            "the {foot} sole is supported over {area:.2} cm2 only, at least {limit:.2} cm2 are needed"
        ));
    }
    Ok(())
}

fn pose_margin(
    model: &RobotModel,
    config: &CheckerConfig,
    contact: &Contact,
    sample: &Sample,
) -> Result<f64, Violation> {
    let limb = contact.limb as usize;
    let foot = &model.feet[limb].name;
    let declared = contact.world_from_sole();
    let actual = sample.posture.world_from_sole(model, limb);
    let bad = |detail| Err(Violation::new(Check::Contact, sample.waypoint, detail));
    let distance = declared.translation.distance(actual.translation);
    if !is_at_most(distance, config.foot_position_max) {
        let limit = 1e3 * config.foot_position_max;
        return bad(format!(
            "the {foot} sole is {:.3} mm from its declared place, limit {limit:.3} mm",
            1e3 * distance
        ));
    }
    let turn = rotation_distance(declared.rotation.normalize(), actual.rotation);
    if !is_at_most(turn, config.foot_rotation_max) {
        let (turn, limit) = (turn.to_degrees(), config.foot_rotation_max.to_degrees());
        return bad(format!(
            "the {foot} sole is turned {turn:.3} deg from its declared pose, limit {limit:.3} deg"
        ));
    }
    Ok(config.foot_position_max - distance)
}
