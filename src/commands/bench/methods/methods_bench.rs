//! `surefoot bench methods`: success, time, work and steps of every method in every scenario.

use std::fmt::Write;

use serde::Serialize;
use surefoot_planner::methods::method::Method;

use crate::cli::bench_arguments::MethodsArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_trial::{MethodRow, MethodSetup};
use crate::commands::bench::scenarios;
use crate::commands::bench::table::{aligned, count, seconds};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

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

/// Everything that was measured.
#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    machine: Machine,
    work_max: u64,
    rows: Vec<MethodRow>,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, a result cannot be written, or a signal comes.
pub fn run(arguments: &MethodsArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let methods = if arguments.methods.is_empty() { &Method::ALL[..] } else { &arguments.methods };
    let mut rows = vec![];
    for inputs in &scenarios {
        for &method in methods {
            let setup = MethodSetup {
                inputs,
                method,
                parameters: arguments.samples.parameters(),
                work_max: arguments.work,
                threads: arguments.threads.count(),
                check: arguments.check,
            };
            let trials = (1..=arguments.trials)
                .map(|seed| setup.run(seed))
                .collect::<Result<Vec<_>, _>>()?;
            rows.push(MethodRow::of(&setup, &trials));
        }
    }
    let report =
        Report { schema: "surefoot-bench-methods/1", machine, work_max: arguments.work, rows };
    if let Some(folder) = &arguments.out {
        output_files::write_json(&report, &folder.join("methods.json"))?;
        output_files::write_text(&csv(&report.rows), &folder.join("methods.csv"))?;
    }
    let text = if arguments.json { json(&report)? } else { table(&report.rows) };
    terminal::print_result(&text);
    let is_refused = report.rows.iter().any(|row| row.refused > 0);
    Ok(if is_refused { CommandOutcome::Refused } else { CommandOutcome::Done })
}

/// A report as JSON.
///
/// # Errors
/// When it cannot be written.
pub fn json(report: &impl Serialize) -> Result<String, CommandError> {
    serde_json::to_string_pretty(report)
        .map_err(|error| CommandError::Output { path: "stdout".into(), reason: error.to_string() })
}

/// A table of rows.
pub fn table(rows: &[MethodRow]) -> String {
    let head = ["scenario", "method", "rho/R_max", "found", "time", "work", "steps", "otherwise"];
    let cells = |row: &MethodRow| {
        let share = row.disc_radius_share.map_or("-".to_owned(), |share| share.to_string());
        vec![
            row.scenario.clone(),
            row.method.clone(),
            share,
            format!("{}/{}", row.found, row.trials),
            seconds(row.mean_seconds),
            count(row.mean_work),
            count(row.mean_steps),
            row.failures(),
        ]
    };
    let head = head.map(str::to_owned).to_vec();
    aligned(&std::iter::once(head).chain(rows.iter().map(cells)).collect::<Vec<_>>())
}

/// The rows as CSV.
pub fn csv(rows: &[MethodRow]) -> String {
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let mut text = "scenario,method,rho_share,trials,found,mean_seconds,mean_work,mean_steps,\
                    checked,refused,otherwise\n"
        .to_owned();
    for row in rows {
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{}",
            row.scenario,
            row.method,
            number(row.disc_radius_share),
            row.trials,
            row.found,
            number(row.mean_seconds),
            number(row.mean_work),
            number(row.mean_steps),
            row.checked,
            row.refused,
            row.failures().replace(',', ";"),
        );
    }
    text
}
