//! One search by one method.

use std::num::NonZeroUsize;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use surefoot_planner::Planner;
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_shared_types::base::digest::Digest;

use crate::commands::bench::journal::Journal;
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
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MethodTrial {
    /// Time, work and outcome.
    pub trial: Trial,
    /// The method's name.
    pub method: String,
    /// Steps of the plan.
    pub steps: u64,
}

impl AsRef<Trial> for MethodTrial {
    fn as_ref(&self) -> &Trial {
        &self.trial
    }
}

impl MethodSetup<'_> {
    /// Searches with these seeds, but for those whose results the journal of this `program` holds.
    ///
    /// # Errors
    /// When the planner cannot be made, a plan cannot be checked, the journal cannot be written,
    /// or a signal comes.
    pub fn trials(
        &self,
        seeds: Range<u64>,
        program: &str,
        journal: &mut Journal<MethodTrial>,
    ) -> Result<Vec<MethodTrial>, CommandError> {
        seeds
            .map(|seed| {
                let key = self.key(program, seed);
                journal.find_or_make(&key, self.check, || self.run(key.clone(), seed))
            })
            .collect()
    }

    /// Names all that a trial's result depends on.
    fn key(&self, program: &str, seed: u64) -> String {
        let method = format!("{} {:?} {}", self.method.name(), self.parameters, self.work_max);
        let trial = self.trial_setup(seed).key(program);
        Digest::of(&[trial.as_bytes(), method.as_bytes()]).to_string()
    }

    /// Searches with a seed and measures; checks the plan if requested.
    fn run(&self, key: String, seed: u64) -> Result<MethodTrial, CommandError> {
        let (trial, planner) = self.search(seed)?;
        let setup = self.trial_setup(seed);
        let check_result =
            if trial.is_found() && self.check { Some(setup.check_result(&planner)?) } else { None };
        Ok(MethodTrial {
            trial: Trial { key, check_result, ..trial },
            method: self.method.name().to_owned(),
            steps: planner.steps(),
        })
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
