//! One search, measured.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;

use serde::{Deserialize, Serialize};
use surefoot_controller_sim::check_plan;
use surefoot_planner::Planner;
use surefoot_planner::pipeline::WorkCategory;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::plan_file::write::plan_from_chunks;

use crate::commands::bench::pieces;
use crate::commands::search_loop;
use crate::input::inputs::Inputs;
use crate::report::command_error::CommandError;
use crate::system::clock::{Stopwatch, processor_seconds};

/// Work units between two checks for a signal while stages are timed.
const STAGE_WORK: u64 = 20_000;
/// Seeds up to this one are searched a second time, to measure the time of each stage.
const STAGED_SEEDS_MAX: u64 = 5;

/// The measurements of one search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Digest of everything that the result depends on, see [`TrialSetup::key`].
    pub key: String,
    /// The scenario's name.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Planner threads.
    pub threads: usize,
    /// The search's outcome; `found` if there is a plan.
    pub outcome: String,
    /// Time from request to ready: `Planner::new`, s.
    pub ready_seconds: f64,
    /// Time from ready to the outcome, s.
    pub seconds: f64,
    /// Time from ready until the first chunk was final, s; of a plan that is not made in parts,
    /// until it was complete.
    #[serde(default)]
    pub first_chunk_seconds: Option<f64>,
    /// Processor time of all threads during the search, s.
    pub processor_seconds: f64,
    /// Work units.
    pub work: u64,
    /// Work units by stage.
    pub work_by_stage: BTreeMap<String, u64>,
    /// Seconds by stage, where they were measured.
    pub seconds_by_stage: Option<BTreeMap<String, f64>>,
    /// Waypoints of the plan.
    pub waypoints: u64,
    /// Bytes of the planner's arenas.
    pub arena_bytes: u64,
    /// The plan's digest.
    pub digest: Option<String>,
    /// Result of the controller's checks, if they ran: `accepted` or the first violation.
    pub check_result: Option<String>,
}

/// The setup of a trial.
#[derive(Debug)]
pub struct TrialSetup<'a> {
    /// Scenario, robot and world.
    pub inputs: &'a Inputs,
    /// The seed, in place of the scenario's.
    pub seed: u64,
    /// Planner threads.
    pub threads: NonZeroUsize,
    /// Whether the controller checks the plan.
    pub check: bool,
}

impl AsRef<Self> for Trial {
    fn as_ref(&self) -> &Self {
        self
    }
}

impl Trial {
    /// Whether a plan was found.
    pub fn is_found(&self) -> bool {
        self.outcome == "found"
    }

    /// Whether the controller's checks refused the plan.
    pub fn is_refused(&self) -> bool {
        self.check_result.as_ref().is_some_and(|check_result| check_result != "accepted")
    }
}

impl TrialSetup<'_> {
    /// Names all that the answer depends on: robot, world, scenario, seed, threads and the
    /// `program`.
    pub fn key(&self, program: &str) -> String {
        let Inputs { model, world, .. } = self.inputs;
        let scenario = self.scenario().digest;
        let threads = (self.threads.get() as u64).to_le_bytes();
        Digest::of(&[program.as_bytes(), &model.digest.0, &world.digest.0, &scenario.0, &threads])
            .to_string()
    }

    /// Searches and measures, and checks the plan if requested. Nothing else runs meanwhile.
    ///
    /// # Errors
    /// When the planner cannot be made, the plan cannot be checked, or a signal comes.
    pub fn run(&self, program: &str) -> Result<Trial, CommandError> {
        let (trial, planner) = self.search(program)?;
        let check_result =
            if trial.is_found() && self.check { Some(self.check_result(&planner)?) } else { None };
        drop(planner);
        let seconds_by_stage =
            if self.seed <= STAGED_SEEDS_MAX { Some(self.stages()?) } else { None };
        Ok(Trial { check_result, seconds_by_stage, ..trial })
    }

    /// Searches and measures; answers the planner too.
    ///
    /// # Errors
    /// When the planner cannot be made, or a signal comes.
    pub fn search(&self, program: &str) -> Result<(Trial, Planner), CommandError> {
        self.inputs.preparation(false)?;
        self.search_with(program, &|| self.new_planner(&self.scenario()))
    }

    /// Searches and measures with the planner that is made for it; answers that planner too.
    ///
    /// # Errors
    /// When the planner cannot be made, or a signal comes.
    pub fn search_with(
        &self,
        program: &str,
        make: &dyn Fn() -> Result<Planner, CommandError>,
    ) -> Result<(Trial, Planner), CommandError> {
        let scenario = self.scenario();
        let watch = Stopwatch::start();
        let mut planner = make()?;
        let ready_seconds = watch.seconds();
        let processor = processor_seconds();
        let planned = search_loop::run(&mut planner, scenario.planner.work_max, &mut |_| Ok(()))?;
        let spent = processor_seconds() - processor;
        let trial = Trial {
            key: self.key(program),
            scenario: scenario.name,
            seed: self.seed,
            threads: self.threads.get(),
            outcome: planned.outcome,
            ready_seconds,
            seconds: planned.plan_seconds,
            first_chunk_seconds: planned.first_chunk_seconds,
            processor_seconds: spent,
            work: planned.work,
            work_by_stage: named(planner.stats().work_by_category),
            seconds_by_stage: None,
            waypoints: planned.waypoints,
            arena_bytes: planner.arena_bytes().iter().map(|(_, bytes)| *bytes as u64).sum(),
            digest: planned.digest,
            check_result: None,
        };
        Ok((trial, planner))
    }

    /// Searches stage by stage, and times each: seconds by stage.
    ///
    /// # Errors
    /// When the planner cannot be made, or a signal comes.
    pub fn stages(&self) -> Result<BTreeMap<String, f64>, CommandError> {
        let mut planner = self.new_planner(&self.scenario())?;
        let mut seconds = [0.0; WorkCategory::COUNT];
        pieces::search(&mut planner, |planner| planner.step_category(STAGE_WORK), &mut |piece| {
            seconds[piece.stage] += piece.seconds
        })?;
        Ok(named(seconds))
    }

    fn scenario(&self) -> Scenario {
        self.inputs.scenario.clone().with_seed(self.seed)
    }

    fn new_planner(&self, scenario: &Scenario) -> Result<Planner, CommandError> {
        Ok(Planner::builder(
            &self.inputs.model,
            &self.inputs.world,
            scenario,
            self.inputs.preparation(false)?,
        )
        .threads(self.threads)
        .in_parts()
        .build()?)
    }

    /// The result of the controller's checks of a plan: `accepted` or the first violation.
    ///
    /// # Errors
    /// The plan cannot be checked.
    pub fn check_result(&self, planner: &Planner) -> Result<String, CommandError> {
        let folder = Path::new(".");
        let plan = plan_from_chunks(
            &self.inputs.model,
            &self.inputs.world,
            &self.scenario(),
            planner.chunks(),
            folder,
        );
        let report = check_plan(&plan, &folder.join("plan.json"))?;
        let of_ends =
            [&report.start, &report.goal].into_iter().filter_map(|end| end.violation.clone());
        let first = report
            .violations()
            .map(|placed| format!("phase {}: {}", placed.phase, placed.violation))
            .chain(of_ends)
            .next();
        Ok(first.unwrap_or_else(|| "accepted".to_owned()))
    }
}

fn named<T>(by_stage: [T; WorkCategory::COUNT]) -> BTreeMap<String, T> {
    WorkCategory::NAMES.into_iter().map(str::to_owned).zip(by_stage).collect()
}
