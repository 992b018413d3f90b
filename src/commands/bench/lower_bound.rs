//! `surefoot bench lower-bound`: planning time against its lower bound, the time of checking the
//! plan once. The planner's self-check runs on one thread, over every waypoint and every motion
//! between two waypoints, in the planner's resolution.

use serde::Serialize;
use surefoot_planner::Planner;
use surefoot_planner::plan::self_check::{SelfCheckError, SelfCheckStats, self_check};

use crate::cli::bench_arguments::LowerBoundArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::row::Row;
use crate::commands::bench::scenarios;
use crate::commands::bench::statistics::{mean, quantile};
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::processor_seconds;

/// The default scenarios: all that have a plan, without the longer gauntlets.
const SCENARIOS: [&str; 18] = [
    "flat_walk",
    "ibeam_hallway",
    "ibeam_gap",
    "stepping_stones",
    "checkers",
    "cinder_blocks",
    "rough_ground",
    "stairs_bauzil",
    "sl1m_complex",
    "pass_under",
    "beam",
    "monkey_bars",
    "stairs",
    "spiral_steps",
    "jungle_gym_full",
    "jungle_gym_spiral_route",
    "jungle_gym_stair_route",
    "gauntlet_1",
];
/// Checks of each plan, of which the median counts.
const REPEATS: usize = 5;

/// Everything that is reported.
#[derive(Debug, Serialize)]
struct LowerBoundReport {
    schema: &'static str,
    machine: Machine,
    rows: Vec<LowerBoundRow>,
}

/// One scenario.
#[derive(Debug, Serialize)]
struct LowerBoundRow {
    #[serde(flatten)]
    search: Row,
    /// Mean processor time of checking the plan once, s.
    check_mean_seconds: Option<f64>,
    /// Mean number of checked configurations.
    check_mean_configurations: Option<f64>,
    /// Mean processor time of the search divided by mean check time. Load affects both alike.
    ratio: Option<f64>,
    /// Plans that failed the check, which means an error of the planner.
    faults: Vec<String>,
}

/// A plan's check, measured.
struct Check {
    seconds: f64,
    outcome: Result<SelfCheckStats, SelfCheckError>,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, or a signal comes.
pub fn run(arguments: &LowerBoundArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let rows = scenarios
        .iter()
        .map(|inputs| row(arguments, inputs, &machine.program))
        .collect::<Result<Vec<_>, _>>()?;
    let report = LowerBoundReport { schema: "surefoot-bench-lower-bound/1", machine, rows };
    print_report(&report, arguments.json, || text(&report))?;
    let (faulty, lacking) = (
        report.rows.iter().any(|row| !row.faults.is_empty()),
        report.rows.iter().any(|row| row.search.found < row.search.trials),
    );
    Ok(match (faulty, lacking) {
        (true, _) => CommandOutcome::Refused,
        (false, true) => CommandOutcome::NoPlan,
        (false, false) => CommandOutcome::Done,
    })
}

fn row(
    arguments: &LowerBoundArguments,
    inputs: &Inputs,
    program: &str,
) -> Result<LowerBoundRow, CommandError> {
    let mut trials: Vec<Trial> = vec![];
    let mut checks: Vec<Check> = vec![];
    for seed in 1..=arguments.trials {
        let setup = TrialSetup { inputs, seed, threads: arguments.threads.count(), check: false };
        let (trial, planner) = setup.search(program)?;
        if trial.is_found() {
            checks.push(check(&planner));
        }
        trials.push(Trial { seconds_by_stage: Some(setup.stages()?), ..trial });
    }
    let search = Row::of(&trials);
    let check_mean_seconds = mean(&checks.iter().map(|check| check.seconds).collect::<Vec<_>>());
    let configurations: Vec<f64> = checks
        .iter()
        .filter_map(|check| check.outcome.ok())
        .map(|done| (done.waypoints + done.between) as f64)
        .collect();
    let fault = |(index, check): (usize, &Check)| {
        check.outcome.err().map(|fault| format!("plan {}: {fault:?}", index + 1))
    };
    Ok(LowerBoundRow {
        check_mean_seconds,
        check_mean_configurations: mean(&configurations),
        ratio: search
            .processor_mean_seconds
            .zip(check_mean_seconds)
            .map(|(search, check)| search / check),
        faults: checks.iter().enumerate().filter_map(fault).collect(),
        search,
    })
}

fn check(planner: &Planner) -> Check {
    let mut times = [0.0; REPEATS];
    let mut outcome = Ok(SelfCheckStats::default());
    for time in &mut times {
        let begin = processor_seconds();
        outcome = self_check(planner.constraints(), planner.chunks());
        *time = processor_seconds() - begin;
    }
    times.sort_by(f64::total_cmp);
    Check { seconds: quantile(&times, 0.5).unwrap_or(0.0), outcome }
}

fn text(report: &LowerBoundReport) -> String {
    let head = [
        "scenario",
        "threads",
        "found",
        "plan",
        "processor",
        "check once",
        "ratio",
        "configurations",
        "waypoints",
        "mean work",
    ];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(report.rows.iter().map(|row| {
        vec![
            row.search.scenario.clone(),
            row.search.threads.to_string(),
            format!("{}/{}", row.search.found, row.search.trials),
            seconds(row.search.mean_seconds),
            seconds(row.search.processor_mean_seconds),
            seconds(row.check_mean_seconds),
            row.ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.1} x")),
            count(row.check_mean_configurations),
            count(row.search.mean_waypoints),
            count(row.search.mean_work),
        ]
    }));
    let mut parts = vec![
        format!("machine: {}", report.machine.describe()),
        String::new(),
        aligned(&cells),
        String::new(),
    ];
    parts.push("Mean time of each stage".to_owned());
    parts.push(crate::commands::bench::row::stages(report.rows.iter().map(|row| &row.search)));
    parts.extend(report.rows.iter().flat_map(|row| {
        row.faults.iter().map(|fault| format!("FAULT {}: {fault}", row.search.scenario))
    }));
    parts.join("\n")
}
