//! One search by one method, and the statistics of several.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use serde::Serialize;
use surefoot_planner::Planner;
use surefoot_planner::methods::method::{Method, MethodParameters};

use crate::commands::bench::statistics::mean;
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::input::inputs::Inputs;
use crate::report::command_error::CommandError;

/// The searches of one method in one scenario.
#[derive(Debug, Clone, Copy)]
pub struct MethodSetup<'a> {
    /// Scenario, robot and world.
    pub inputs: &'a Inputs,
    /// The method.
    pub method: Method,
    /// Its parameters.
    pub parameters: MethodParameters,
    /// Work limit of each search, units.
    pub work_max: u64,
    /// Planner threads.
    pub threads: NonZeroUsize,
    /// Whether the controller checks the plans.
    pub check: bool,
}

/// The measurements of one search.
#[derive(Debug, Clone)]
struct MethodTrial {
    /// Time, work and outcome.
    trial: Trial,
    /// Steps of the plan.
    steps: u64,
}

impl MethodSetup<'_> {
    /// Searches with the seeds 1 to `trials`.
    ///
    /// # Errors
    /// When the planner cannot be made, a plan cannot be checked, or a signal comes.
    pub fn row(&self, trials: u64) -> Result<MethodRow, CommandError> {
        let trials = (1..=trials).map(|seed| self.run(seed)).collect::<Result<Vec<_>, _>>()?;
        Ok(MethodRow::of(self, &trials))
    }

    /// Searches with a seed and measures; checks the plan if requested.
    fn run(&self, seed: u64) -> Result<MethodTrial, CommandError> {
        let (trial, planner) = self.search(seed)?;
        let setup = self.trial_setup(seed);
        let check_result =
            if trial.is_found() && self.check { Some(setup.check_result(&planner)?) } else { None };
        Ok(MethodTrial { steps: planner.steps(), trial: Trial { check_result, ..trial } })
    }

    /// Searches with a seed; returns the planner, too.
    ///
    /// # Errors
    /// When the planner cannot be made, or a signal comes.
    pub fn search(&self, seed: u64) -> Result<(Trial, Planner), CommandError> {
        let Inputs { model, world, scenario, .. } = self.inputs;
        let scenario = scenario.clone().with_seed(seed);
        let preparation = self.inputs.preparation(false)?;
        let make = || {
            let mut planner = Planner::builder(model, world, &scenario, preparation.clone())
                .threads(self.threads)
                .method(self.method, self.parameters)
                .build()?;
            planner.limit_work(self.work_max);
            Ok(planner)
        };
        self.trial_setup(seed).search_with(self.method.name(), &make)
    }

    fn trial_setup(&self, seed: u64) -> TrialSetup<'_> {
        TrialSetup { inputs: self.inputs, seed, threads: self.threads, check: self.check }
    }
}

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
    fn of(setup: &MethodSetup<'_>, trials: &[MethodTrial]) -> Self {
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
