//! The options of the methods.

use clap::Args;
use surefoot_planner::methods::method::{Method, MethodParameters};

use crate::cli::values::{positive, whole_number, whole_number_between};

/// The parameters of the methods w-rpg, rpg-discs and mmprm.
#[derive(Debug, Clone, Copy, Args)]
pub struct MethodArguments {
    /// w-rpg: samples of C_N of one round
    #[arg(
        long,
        value_name = "N",
        default_value_t = MethodParameters::default().route_samples,
        value_parser = whole_number_between::<u32>(1, 1_000)
    )]
    pub route_samples: u32,
    /// w-rpg, rpg-discs, mmprm: placements of each foot of one round
    #[arg(
        long,
        value_name = "N",
        default_value_t = MethodParameters::default().placements,
        value_parser = whole_number_between::<u32>(1, 100_000)
    )]
    pub placements: u32,
    /// w-rpg, rpg-discs: radius of the first discs about the route, relative to the longest level
    /// step
    #[arg(
        long,
        value_name = "X",
        default_value_t = MethodParameters::default().disc_radius_share,
        value_parser = positive
    )]
    pub rho: f64,
    /// w-rpg, rpg-discs: growth of the radius with each further round, up to twice the longest
    /// level step; 1: none
    #[arg(
        long,
        value_name = "G",
        default_value_t = MethodParameters::default().disc_radius_growth,
        value_parser = growth
    )]
    pub rho_growth: f64,
    /// w-rpg, mmprm: most rounds; 0: until the work limit
    #[arg(
        long,
        value_name = "N",
        default_value_t = MethodParameters::default().rounds_max,
        value_parser = whole_number::<u32>
    )]
    pub rounds_max: u32,
}

impl MethodArguments {
    /// The parameters.
    pub fn parameters(self) -> MethodParameters {
        let Self { route_samples, placements, rho, rho_growth, rounds_max } = self;
        MethodParameters {
            route_samples,
            placements,
            disc_radius_share: rho,
            disc_radius_growth: rho_growth,
            rounds_max,
        }
    }
}

fn growth(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 1.0);
    number.ok_or_else(|| "a number of at least 1 is needed".into())
}

/// A method by its name.
pub fn method(name: &str) -> Result<Method, String> {
    let names = Method::ALL.map(Method::name).join(", ");
    Method::from_name(name).ok_or_else(|| format!("one of {names} is needed"))
}
