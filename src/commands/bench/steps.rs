//! `surefoot bench steps`: times of `step` with a millisecond's work, as in a control loop, and the
//! cost of a work unit of each stage. One thread, pinned to a core, with locked memory if
//! permitted.

use serde::Serialize;
use surefoot_planner::pipeline::WorkCategory;
use surefoot_planner::{Outcome, Planner, Status};

use crate::cli::bench_arguments::StepsArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::pieces;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scenarios;
use crate::commands::bench::statistics::{Summary, mean};
use crate::commands::bench::table::{aligned, seconds};
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::{cores, memory, signals};

/// The default scenarios.
const SCENARIOS: [&str; 4] = ["flat_walk", "ibeam_gap", "stepping_stones", "stairs"];

/// Everything that is reported.
#[derive(Debug, Serialize)]
struct StepsReport {
    schema: &'static str,
    machine: Machine,
    /// The core that the bench was pinned to.
    core: usize,
    /// `locked`, or why memory could not be locked.
    memory: String,
    /// Intended duration of a step, s.
    step_seconds: f64,
    rows: Vec<StepsRow>,
}

/// One scenario.
#[derive(Debug, Serialize)]
struct StepsRow {
    scenario: String,
    /// Searches made in such steps: one.
    trials: usize,
    /// Of these, those that found a plan.
    found: usize,
    /// The search's outcome.
    outcome: &'static str,
    /// Work units of the intended duration, by the mean of a whole search.
    step_work: u64,
    /// Steps made.
    steps: usize,
    /// Times of the steps, s.
    mean_seconds: f64,
    std_seconds: f64,
    p50_seconds: f64,
    p95_seconds: f64,
    p99_seconds: f64,
    max_seconds: f64,
    /// Mean work units of a step.
    mean_work: f64,
    /// The most work units in one step.
    max_work: u64,
    /// Most work units by which a step exceeded its budget.
    overrun_work: u64,
    /// The plan's digest, if one was found.
    digest: Option<String>,
    /// Costs of the pieces of each stage.
    stages: Vec<StageRow>,
}

/// Costs of the pieces of one stage. A piece is the smallest advance of the planner.
#[derive(Debug, Clone, Default, Serialize)]
struct StageRow {
    stage: &'static str,
    pieces: u64,
    work: u64,
    seconds: f64,
    /// Seconds per unit of work.
    unit_seconds: f64,
    longest_seconds: f64,
    longest_work: u64,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, or a signal comes.
pub fn run(arguments: &StepsArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let core = arguments.core.unwrap_or_else(|| cores::cores() - 1);
    if core >= cores::cores() {
        return Err(CommandError::Usage(format!(
            "--core {core}: this process may use the cores 0 to {}",
            cores::cores() - 1
        )));
    }
    let step_seconds = f64::from(arguments.step) * 1e-6;
    cores::pin(Some(core));
    let memory = memory::lock()
        .map_or_else(|reason| format!("not locked: {reason}"), |()| "locked".to_owned());
    let rows =
        scenarios.iter().map(|inputs| row(inputs, step_seconds)).collect::<Result<Vec<_>, _>>()?;
    let report =
        StepsReport { schema: "surefoot-bench-steps/1", machine, core, memory, step_seconds, rows };
    print_report(&report, arguments.json, || text(&report))?;
    Ok(if report.rows.iter().all(|row| row.outcome == Outcome::Found.name()) {
        CommandOutcome::Done
    } else {
        CommandOutcome::NoPlan
    })
}

fn row(inputs: &Inputs, step_seconds: f64) -> Result<StepsRow, CommandError> {
    let (seconds, stages) = pieces(inputs)?;
    let work: u64 = stages.iter().map(|stage| stage.work).sum();
    let step_work = (step_seconds * work as f64 / seconds).max(1.0) as u64;
    let steps = steps(inputs, step_work)?;
    let times: Vec<f64> = steps.taken.iter().map(|step| step.0).collect();
    let works: Vec<u64> = steps.taken.iter().map(|step| step.1).collect();
    let summary = Summary::of(&times).unwrap_or(Summary {
        mean: 0.0,
        std: 0.0,
        p50: 0.0,
        p95: 0.0,
        p99: 0.0,
        max: 0.0,
    });
    let max_work = works.into_iter().max().unwrap_or(0);
    Ok(StepsRow {
        scenario: inputs.scenario.name.clone(),
        trials: 1,
        found: usize::from(steps.digest.is_some()),
        outcome: steps.outcome.name(),
        step_work,
        steps: times.len(),
        mean_seconds: summary.mean,
        std_seconds: summary.std,
        p50_seconds: summary.p50,
        p95_seconds: summary.p95,
        p99_seconds: summary.p99,
        max_seconds: summary.max,
        mean_work: mean(&steps.taken.iter().map(|step| step.1 as f64).collect::<Vec<_>>())
            .unwrap_or(0.0),
        max_work,
        overrun_work: max_work.saturating_sub(step_work),
        digest: steps.digest,
        stages,
    })
}

/// Steps made: time in s and work units of each.
struct Steps {
    taken: Vec<(f64, u64)>,
    outcome: Outcome,
    digest: Option<String>,
}

fn new_planner(inputs: &Inputs) -> Result<Planner, CommandError> {
    Ok(Planner::builder(&inputs.model, &inputs.world, &inputs.scenario, inputs.preparation(false)?)
        .build()?)
}

/// A search in steps of `step_work` units.
fn steps(inputs: &Inputs, step_work: u64) -> Result<Steps, CommandError> {
    let mut planner = new_planner(inputs)?;
    let mut taken = vec![];
    loop {
        let before = planner.stats().work;
        let watch = Stopwatch::start();
        let status = planner.step(step_work);
        taken.push((watch.seconds(), planner.stats().work - before));
        if let Status::Done(outcome) = status {
            let digest = (outcome == Outcome::Found).then(|| planner.digest().to_string());
            return Ok(Steps { taken, outcome, digest });
        }
        if let Some(signal) = signals::raised() {
            return Err(CommandError::Interrupted(signal));
        }
    }
}

/// The time of a search in the smallest pieces, in all and by stage.
fn pieces(inputs: &Inputs) -> Result<(f64, Vec<StageRow>), CommandError> {
    let mut planner = new_planner(inputs)?;
    let mut rows = WorkCategory::NAMES.map(|stage| StageRow { stage, ..StageRow::default() });
    pieces::search(&mut planner, |planner| planner.step(1), &mut |piece| {
        let row = &mut rows[piece.stage];
        row.pieces += 1;
        row.work += piece.work;
        row.seconds += piece.seconds;
        row.unit_seconds = row.seconds / row.work.max(1) as f64;
        row.longest_seconds = row.longest_seconds.max(piece.seconds);
        row.longest_work = row.longest_work.max(piece.work);
    })?;
    Ok((rows.iter().map(|row| row.seconds).sum(), rows.to_vec()))
}

fn text(report: &StepsReport) -> String {
    let head = [
        "scenario",
        "outcome",
        "units/step",
        "steps",
        "p50",
        "p95",
        "p99",
        "max",
        "max units",
        "overrun",
    ];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(report.rows.iter().map(|row| {
        let mut cells = vec![
            row.scenario.clone(),
            row.outcome.to_owned(),
            row.step_work.to_string(),
            row.steps.to_string(),
        ];
        cells.extend(
            [row.p50_seconds, row.p95_seconds, row.p99_seconds, row.max_seconds]
                .map(|time| seconds(Some(time))),
        );
        cells.extend([row.max_work, row.overrun_work].map(|work| work.to_string()));
        cells
    }));
    let head = [
        "scenario, stage",
        "pieces",
        "units",
        "time",
        "per unit",
        "longest piece",
        "largest piece",
    ];
    let mut stages = vec![head.map(str::to_owned).to_vec()];
    stages.extend(
        report
            .rows
            .iter()
            .flat_map(|row| row.stages.iter().map(move |stage| stage_cells(&row.scenario, stage))),
    );
    [
        format!("machine: {}", report.machine.describe()),
        format!(
            "core {}, memory {}, steps of {}",
            report.core,
            report.memory,
            seconds(Some(report.step_seconds))
        ),
        String::new(),
        aligned(&cells),
        String::new(),
        "What a unit of work costs in each stage; a piece is the least that a step advances by"
            .to_owned(),
        aligned(&stages),
    ]
    .join("\n")
}

fn stage_cells(scenario: &str, stage: &StageRow) -> Vec<String> {
    vec![
        format!("{scenario}, {}", stage.stage),
        stage.pieces.to_string(),
        stage.work.to_string(),
        seconds(Some(stage.seconds)),
        seconds(Some(stage.unit_seconds)),
        seconds(Some(stage.longest_seconds)),
        format!("{} units", stage.longest_work),
    ]
}
