//! `surefoot bench replan`: time of replanning from the rest state after the controller refused a
//! chunk. It runs the planner process's code from the controller's feedback on, without transport.

use crate::commands::bench::print_report::print_report;
use crate::commands::bench::replan::refusals;
use serde::Serialize;
use surefoot_shared_types::message::PlanChunk;

use crate::cli::bench_arguments::ReplanArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::row::Row;
use crate::commands::bench::scenarios;
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::commands::plan::planning_task::PlanningTask;
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};

/// The default scenarios.
const SCENARIOS: [&str; 3] = ["ibeam_gap", "stepping_stones", "cinder_blocks"];

/// Everything that is reported.
#[derive(Debug, Serialize)]
struct ReplanReport {
    schema: &'static str,
    machine: Machine,
    rows: Vec<ReplanRow>,
}

/// One scenario; the trials are the times that it was planned again.
#[derive(Debug, Serialize)]
struct ReplanRow {
    #[serde(flatten)]
    search: Row,
    /// Plans of which chunks were refused.
    plans: usize,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, or a signal comes.
pub fn run(arguments: &ReplanArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let rows = scenarios
        .iter()
        .map(|inputs| row(arguments, inputs, &machine.program))
        .collect::<Result<Vec<_>, _>>()?;
    let report = ReplanReport { schema: "surefoot-bench-replan/1", machine, rows };
    print_report(&report, arguments.json, || text(&report))?;
    let is_complete = |row: &ReplanRow| {
        row.plans as u64 == arguments.trials && row.search.found == row.search.trials
    };
    Ok(if report.rows.iter().all(is_complete) {
        CommandOutcome::Done
    } else {
        CommandOutcome::NoPlan
    })
}

fn row(
    arguments: &ReplanArguments,
    inputs: &Inputs,
    program: &str,
) -> Result<ReplanRow, CommandError> {
    let (mut plans, mut trials) = (0, vec![]);
    for seed in 1..=arguments.trials {
        let inputs = Inputs { scenario: inputs.scenario.clone().with_seed(seed), ..inputs.clone() };
        let setup =
            TrialSetup { inputs: &inputs, seed, threads: arguments.threads.count(), check: false };
        let (first, planner) = setup.search(program)?;
        let chunks = planner.chunks().to_vec();
        drop(planner);
        if first.is_found() {
            plans += 1;
            trials.extend(again(arguments, &setup, &chunks, program)?);
        }
    }
    let scenario = inputs.scenario.name.clone();
    Ok(ReplanRow { search: Row { scenario, ..Row::of(&trials) }, plans })
}

/// The rest of the way, planned again after each of some refusals of a plan's chunks.
fn again(
    arguments: &ReplanArguments,
    setup: &TrialSetup,
    chunks: &[PlanChunk],
    program: &str,
) -> Result<Vec<Trial>, CommandError> {
    let inputs = setup.inputs;
    let replan = |feedback| {
        let mut task = PlanningTask::first(inputs).after(inputs, &feedback, &[], 0)?;
        task.in_parts = true;
        let make = || Ok(task.planner(&inputs.model, inputs.preparation(true)?, setup.threads)?);
        Ok(setup.search_with(program, &make)?.0)
    };
    refusals::spread(inputs, chunks, arguments.refusals as usize).into_iter().map(replan).collect()
}

fn text(report: &ReplanReport) -> String {
    let head = [
        "scenario",
        "threads",
        "plans",
        "again",
        "found",
        "mean",
        "p50",
        "p95",
        "max",
        "ready",
        "search",
        "mean work",
    ];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(report.rows.iter().map(|row| {
        let Row { scenario, threads, trials, found, mean_work, .. } = &row.search;
        let mut cells = vec![
            scenario.clone(),
            threads.to_string(),
            row.plans.to_string(),
            trials.to_string(),
            found.to_string(),
        ];
        let first = [
            row.search.first_chunk_mean_seconds,
            row.search.first_chunk_p50_seconds,
            row.search.first_chunk_p95_seconds,
        ];
        let parts = [
            row.search.first_chunk_max_seconds,
            row.search.ready_mean_seconds,
            row.search.mean_seconds,
        ];
        cells.extend(first.into_iter().chain(parts).map(seconds));
        cells.push(count(*mean_work));
        cells
    }));
    [
        format!("machine: {}", report.machine.describe()),
        "From the controller's feedback to the first chunk of the new plan: mean, p50, p95, max; and the means of its parts".to_owned(),
        String::new(),
        aligned(&cells),
    ]
    .join("\n")
}
