//! The centre of mass stays where contact forces within the friction cones can hold it.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest};
use crate::check::motion::Sample;
use crate::check::segment::{Case, Violation};
use crate::check::stance_foot::StanceFoot;
use crate::check::tuning::FRICTION_STEPS;
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium, Region};

/// The share of the friction that is not needed to hold the robot, in sixteenths, rounded down.
/// With the rest alone the centre of mass keeps the required margin inside the region.
pub fn friction_reserve(config: &CheckerConfig, equilibrium: &mut Equilibrium, case: &Case) -> f64 {
    let share = |steps: u32| f64::from(steps) / f64::from(FRICTION_STEPS);
    let mut holds = |steps: u32| {
        let region = equilibrium.region(&case.supports, share(steps));
        let mut margins = case.samples_with_feet().map(|at| margin(&region, at));
        margins.all(|margin| is_at_most(config.com_margin, margin))
    };
    let (mut too_few, mut enough) = (0, FRICTION_STEPS);
    while enough - too_few > 1 {
        let middle = (too_few + enough) / 2;
        if holds(middle) { enough = middle } else { too_few = middle }
    }
    1.0 - share(enough)
}

/// The distance of the centre of mass to the edge of the region, less the most by which it moves
/// when the stance feet take their declared poses, m.
fn margin(region: &Region, (sample, feet): (&Sample, &[StanceFoot])) -> f64 {
    region.margin(sample.centre_of_mass) - largest(feet.iter().map(|foot| foot.shift))
}

/// The smallest distance of the centre of mass to the edge of the equilibrium region and of the
/// contacts' hull, m.
pub fn check_balance(
    model: &RobotModel,
    config: &CheckerConfig,
    equilibrium: &mut Equilibrium,
    case: &Case,
) -> Result<f64, Violation> {
    let region = equilibrium.region(&case.supports, ALL_FRICTION);
    let mut worst = f64::INFINITY;
    for (sample, feet) in case.samples_with_feet() {
        let margin = margin(&region, (sample, feet));
        if !is_at_most(config.com_margin, margin) {
            let feet: Vec<&str> = case
                .contacts
                .iter()
                .map(|contact| model.feet[contact.limb as usize].name.as_str())
                .collect();
            let (feet, limit) = (feet.join(" and "), 1e3 * config.com_margin);
            let detail = if margin == f64::NEG_INFINITY {
                format!("no contact forces of the {feet} foot hold the robot")
            } else {
                let margin = 1e3 * margin;
                format!(
                    "the centre of mass is {margin:.2} mm inside the region that the {feet} foot \
                     can hold, at least {limit:.2} mm are needed"
                )
            };
            return Err(Violation::new(Check::Balance, sample.waypoint, detail));
        }
        worst = worst.min(margin);
    }
    Ok(worst)
}
