//! The statistics of the searches of one method in one scenario.

use std::collections::BTreeMap;

use serde::Serialize;
use surefoot_planner::methods::method::Method;

use crate::commands::bench::methods::method_trial::{MethodSetup, MethodTrial};
use crate::commands::bench::statistics::mean;

/// The statistics of the searches of one method in one scenario. Times, work and steps are means
/// of the searches that found a plan; null where none did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodRow {
    /// The scenario's name.
    pub scenario: String,
    /// The method's name.
    pub method: String,
    /// rho / R_max of the first round; null for methods without discs, infinite ones included.
    pub disc_radius_share: Option<f64>,
    /// Growth of rho with each further round; null likewise.
    pub disc_radius_growth: Option<f64>,
    /// Searches made.
    pub trials: usize,
    /// Searches that found a plan.
    pub found: usize,
    /// How many searches had which outcome.
    pub outcomes: BTreeMap<String, usize>,
    /// Seconds of a search.
    pub mean_seconds: Option<f64>,
    /// Work units of a search.
    pub mean_work: Option<f64>,
    /// Steps of a plan.
    pub mean_steps: Option<f64>,
    /// Plans that the controller checked.
    pub checked: usize,
    /// Plans that it refused.
    pub refused: usize,
}

impl MethodRow {
    /// The row of some searches.
    pub fn of(setup: &MethodSetup<'_>, trials: &[MethodTrial]) -> Self {
        let found: Vec<&MethodTrial> =
            trials.iter().filter(|trial| trial.trial.is_found()).collect();
        let of_found = |value: fn(&MethodTrial) -> f64| {
            mean(&found.iter().map(|trial| value(trial)).collect::<Vec<f64>>())
        };
        let mut outcomes = BTreeMap::new();
        for trial in trials {
            *outcomes.entry(trial.trial.outcome.clone()).or_default() += 1;
        }
        let share = setup.parameters.disc_radius_share;
        let has_discs =
            matches!(setup.method, Method::WRpg | Method::RpgDiscs) && share.is_finite();
        Self {
            scenario: setup.inputs.scenario.name.clone(),
            method: setup.method.name().to_owned(),
            disc_radius_share: has_discs.then_some(share),
            disc_radius_growth: has_discs.then_some(setup.parameters.disc_radius_growth),
            trials: trials.len(),
            found: found.len(),
            outcomes,
            mean_seconds: of_found(|trial| trial.trial.seconds),
            mean_work: of_found(|trial| trial.trial.work as f64),
            mean_steps: of_found(|trial| trial.steps as f64),
            checked: trials.iter().filter(|trial| trial.trial.check_result.is_some()).count(),
            refused: trials.iter().filter(|trial| trial.trial.is_refused()).count(),
        }
    }

    /// The outcomes other than a plan, with their counts.
    pub fn failures(&self) -> String {
        let failed = self.outcomes.iter().filter(|(outcome, _)| *outcome != "found");
        failed.map(|(outcome, count)| format!("{outcome} {count}")).collect::<Vec<_>>().join(", ")
    }
}
