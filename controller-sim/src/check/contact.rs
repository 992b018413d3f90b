//! Stance feet: each stays at its declared pose, and the world supports it there.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Check, Contact};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest, smallest};
use crate::check::segment::{Case, Violation};
use crate::check::stance_foot::StanceFoot;
use crate::check::tuning::{
    LANDING_HEIGHT_MAX, MOVED_HEIGHT_MAX, MOVED_LEVEL_MAX, STRAIGHT_LEVEL_MAX,
};
use crate::statics::sole_support::SoleSupport;

/// What remains of the position tolerance of the stance soles, m.
pub fn check_contact(
    model: &RobotModel,
    config: &CheckerConfig,
    case: &Case,
) -> Result<f64, Violation> {
    let name = |contact: &Contact| &model.feet[contact.limb as usize].name;
    for (contact, support) in case.contacts.iter().zip(&case.supports) {
        check_support(name(contact), config, support)?;
    }
    let heights = if case.is_smooth() { SMOOTH_HEIGHTS } else { STRAIGHT_HEIGHTS };
    let declared = case.supports.iter().map(|support| support.deepest);
    heights[0].check(declared).map_err(|detail| Violation::new(Check::Contact, 0, detail))?;
    let mut worst = f64::INFINITY;
    for (sample, feet) in case.samples_with_feet() {
        let bad = |detail| Violation::new(Check::Contact, sample.waypoint, detail);
        for ((contact, support), foot) in case.contacts.iter().zip(&case.supports).zip(feet) {
            let name = name(contact);
            worst = worst.min(pose_margin(name, config, foot).map_err(bad)?);
            check_gap(name, config, support, foot).map_err(bad)?;
        }
        let depths = case.supports.iter().zip(feet).map(|(on, foot)| on.deepest - foot.lift);
        heights[1].check(depths).map_err(bad)?;
    }
    Ok(worst)
}

/// Whether the soles of a smooth motion are as deep in the ground as each other where one lands.
///
/// # Errors
/// One meets the ground early or late.
pub fn check_landing(supports: &[SoleSupport], feet: &[StanceFoot]) -> Result<(), Violation> {
    let depths = supports.iter().zip(feet).map(|(on, foot)| on.deepest - foot.lift);
    let landing = Heights { off_max: MOVED_HEIGHT_MAX, apart_max: LANDING_HEIGHT_MAX };
    landing
        .check(depths)
        .map_err(|detail| Violation::new(Check::Contact, 0, format!("where a foot lands {detail}")))
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

/// How far soles may be over the ground or in it, and how much deeper one than the other, m.
struct Heights {
    off_max: f64,
    apart_max: f64,
}

/// Those of soles as they are declared, and as they move.
const SMOOTH_HEIGHTS: [Heights; 2] = [
    Heights { off_max: LANDING_HEIGHT_MAX, apart_max: LANDING_HEIGHT_MAX },
    Heights { off_max: MOVED_HEIGHT_MAX, apart_max: MOVED_LEVEL_MAX },
];
/// The same of straight lines, in which a foot is slow where it meets the ground.
const STRAIGHT_HEIGHTS: [Heights; 2] = [
    Heights { off_max: f64::INFINITY, apart_max: f64::INFINITY },
    Heights { off_max: f64::INFINITY, apart_max: STRAIGHT_LEVEL_MAX },
];

impl Heights {
    /// The motion of a smooth plan has no time for a foot that meets the ground early or late.
    /// `depths` (m) are those of the soles in the ground. A robot sinks onto the foot that carries
    /// it, and the other one meets the ground early or late by the difference of their depths.
    fn check(&self, depths: impl Iterator<Item = f64> + Clone) -> Result<(), String> {
        let off = largest(depths.clone().map(f64::abs));
        if !is_at_most(off, self.off_max) {
            let is_over = is_at_most(off, largest(depths.map(|depth| -depth)));
            let side = if is_over { "over" } else { "in" };
            let (off, limit) = (1e3 * off, 1e3 * self.off_max);
            return Err(format!(
                "a sole of a smooth motion is {off:.2} mm {side} the ground, limit {limit:.2} mm"
            ));
        }
        let least = smallest(depths.clone());
        let apart = largest(depths.map(|depth| depth - least));
        if is_at_most(apart, self.apart_max) {
            return Ok(());
        }
        let (apart, limit) = (1e3 * apart, 1e3 * self.apart_max);
        Err(format!(
            "one sole is {apart:.2} mm deeper in the ground than the other, limit {limit:.2} mm"
        ))
    }
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
