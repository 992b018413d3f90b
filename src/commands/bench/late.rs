//! `surefoot bench late`: a smooth plan is walked again and again while its chunks come late at
//! random. Each walk must brake along its path, stand, go on and arrive, and every instant must
//! pass the dynamic checks.

use serde::Serialize;
use surefoot_controller_sim::{Checker, LateChunks, walk_late};
use surefoot_planner::Planner;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::plan_file::write::{executed_plan, save};

use crate::cli::bench_arguments::LateArguments;
use crate::commands::bench::print_report::print_report;
use crate::commands::search_loop;
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::PlanResult;

/// Everything that is reported.
#[derive(Debug, Default, Serialize)]
struct LateReport {
    schema: &'static str,
    scenario: String,
    chunks: usize,
    walks: u64,
    /// Walks that arrived at the goal.
    finished: u64,
    /// Walks in which the robot braked at least once.
    braked: u64,
    /// Chunks that came late, in all walks.
    late: u64,
    /// How often a robot had to stop.
    brakes: u64,
    /// How long robots stood, s.
    stood_seconds: f64,
    /// Instants checked.
    instants: u64,
    /// The first violation of each walk that has one.
    violations: Vec<String>,
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be used, or a signal comes.
pub fn run(arguments: &LateArguments) -> Result<CommandOutcome, CommandError> {
    let overrides = Overrides { motion: Some(MotionKind::Smooth), ..Overrides::default() };
    let inputs = Inputs::load(&arguments.scenario, overrides)?;
    let Some(chunks) = planned(&inputs)? else { return Ok(CommandOutcome::NoPlan) };
    let Inputs { model, world, scenario, .. } = &inputs;
    let mut checker = Checker::new(model.clone(), world.clone(), scenario.checker.clone())
        .map_err(|error| CommandError::Usage(error.to_string()))?;
    let mut report = LateReport {
        schema: "surefoot-bench-late/1",
        scenario: scenario.name.clone(),
        chunks: chunks.len(),
        ..LateReport::default()
    };
    output_files::check_folder(arguments.out.as_deref())?;
    for seed in 1..=arguments.walks {
        CommandError::unless_interrupted()?;
        let late = LateChunks { seed, share: arguments.share };
        let executed = report.add(&late, &mut checker, &chunks);
        if let Some(folder) = arguments.out.as_ref().filter(|_| !executed.is_empty()) {
            let plan = executed_plan(model, world, scenario, (&executed, None), folder);
            save(&plan, &folder.join(format!("{}_late_{seed}.json", scenario.name)))?;
        }
    }
    print_report(&report, arguments.json, || report.text())?;
    let is_right = report.finished == report.walks;
    Ok(if is_right { CommandOutcome::Done } else { CommandOutcome::Refused })
}

/// The chunks of a plan, if there is one.
fn planned(inputs: &Inputs) -> Result<Option<Vec<PlanChunk>>, CommandError> {
    let preparation = inputs.preparation(false)?;
    let Inputs { model, world, scenario, .. } = inputs;
    let mut planner = Planner::builder(model, world, scenario, preparation).build()?;
    let planned = search_loop::run(&mut planner, scenario.planner.work_max, &mut |_| Ok(()))?;
    Ok((planned.result == PlanResult::Found).then(|| planner.chunks().to_vec()))
}

impl LateReport {
    /// Adds a walk. Returns its motion as executed, as far as it passed the checks.
    fn add(
        &mut self,
        late: &LateChunks,
        checker: &mut Checker,
        chunks: &[PlanChunk],
    ) -> Vec<PlanChunk> {
        self.walks += 1;
        match walk_late(checker, chunks, late) {
            Ok(walk) => {
                self.finished += u64::from(walk.is_finished);
                self.braked += u64::from(walk.brakes > 0);
                self.late += walk.late;
                self.brakes += walk.brakes;
                self.stood_seconds += walk.stood;
                self.instants += walk.instants;
                walk.executed
            }
            Err((time, violation)) => {
                let seed = late.seed;
                self.violations.push(format!("seed {seed}, at {time:.3} s: {violation}"));
                Vec::new()
            }
        }
    }

    fn text(&self) -> String {
        let Self { scenario, walks, chunks, finished, braked, .. } = self;
        let mut text = format!(
            "{scenario}: {finished} of {walks} walks of {chunks} chunks arrived, {braked} of them \
             braked; {} late chunks, {} stops, {:.1} s of standing, {} instants checked",
            self.late, self.brakes, self.stood_seconds, self.instants
        );
        self.violations.iter().for_each(|violation| text += &format!("\n{violation}"));
        text
    }
}
