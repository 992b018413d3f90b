//! `surefoot bench methods`: success, time, work and steps of every method in every scenario.

use surefoot_planner::methods::method::Method;

use crate::cli::method_bench_arguments::MethodsArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_journal;
use crate::commands::bench::methods::method_report::MethodReport;
use crate::commands::bench::methods::method_row::MethodRow;
use crate::commands::bench::methods::method_trial::MethodSetup;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scenarios;
use crate::report::command_error::{CommandError, CommandOutcome};

/// The scenarios of the bench.
const SCENARIOS: [&str; 14] = [
    "flat_walk",
    "stepping_stones",
    "checkers",
    "pass_under",
    "ibeam_hallway",
    "ibeam_gap",
    "cinder_blocks",
    "stairs_bauzil",
    "stairs",
    "beam",
    "monkey_bars",
    "spiral_steps",
    "sl1m_complex",
    "jungle_gym_full",
];

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, a result cannot be written, or a signal comes.
pub fn run(arguments: &MethodsArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.common.scenarios, &SCENARIOS)?;
    let (machine, series) = (Machine::this()?, &arguments.series);
    let mut journal = method_journal::open("methods", &arguments.common, series, &machine)?;
    let methods = if arguments.methods.is_empty() { &Method::ALL[..] } else { &arguments.methods };
    let mut rows = vec![];
    for inputs in &scenarios {
        for &method in methods {
            let setup = MethodSetup {
                inputs,
                method,
                parameters: arguments.common.samples.parameters(),
                work_max: arguments.common.work,
                threads: arguments.common.threads.count(),
                check: arguments.check,
            };
            let seeds = series.seeds(arguments.trials);
            let trials = setup.trials(seeds, &machine.program, &mut journal)?;
            rows.push(MethodRow::of(&setup, &trials));
        }
    }
    let schema = "surefoot-bench-methods/1";
    let report = MethodReport { schema, machine, work_max: arguments.common.work, rows };
    if let Some(folder) = &series.out {
        report.save(folder, "methods")?;
    }
    print_report(&report, arguments.common.json, || report.table())?;
    let is_refused = report.rows.iter().any(|row| row.refused > 0);
    Ok(if is_refused { CommandOutcome::Refused } else { CommandOutcome::Done })
}
