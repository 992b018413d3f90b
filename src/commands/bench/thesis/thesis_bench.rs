//! `surefoot bench thesis`: tables 4.1 and 4.2 beside our own times [Grey 4.5].
//!
//! One search runs at a time, with all its threads, and nothing is drawn while it runs. Checks and
//! the second search, for the time of each stage, run outside the measured time.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::bench_arguments::ThesisArguments;
use crate::commands::bench::journal::Journal;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::row::Row;
use crate::commands::bench::scenarios;
use crate::commands::bench::thesis::published::PUBLISHED;
use crate::commands::bench::thesis::report::ThesisReport;
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// When a scenario or the journal cannot be used, a result cannot be written, or a signal comes.
pub fn run(arguments: &ThesisArguments) -> Result<CommandOutcome, CommandError> {
    let all = PUBLISHED.map(|row| row.scenario);
    let overrides = Overrides { motion: Some(arguments.motion), ..scenarios::SEARCHED };
    let scenarios = scenarios::load_with(&arguments.scenarios, &all, overrides)?;
    let machine = Machine::this()?;
    let mut journal =
        Journal::open(arguments.out.as_deref(), "thesis.jsonl", arguments.fresh, None)?;
    let bar = progress_bar(scenarios.len() as u64 * arguments.trials);
    let mut rows = Vec::with_capacity(scenarios.len());
    for inputs in &scenarios {
        rows.push(Row::of(&trials(arguments, inputs, &machine.program, &mut journal, &bar)?));
    }
    bar.finish_and_clear();
    let report = ThesisReport::new(machine, rows);
    if let Some(folder) = &arguments.out {
        output_files::write_json(&report, &folder.join("thesis.json"))?;
    }
    terminal::print_result(&if arguments.json { report.json() } else { report.text() });
    Ok(command_outcome(&report.rows().collect::<Vec<_>>()))
}

/// The trials of one scenario: from the journal where it holds them, made now where not.
fn trials(
    arguments: &ThesisArguments,
    inputs: &Inputs,
    program: &str,
    journal: &mut Journal<Trial>,
    bar: &ProgressBar,
) -> Result<Vec<Trial>, CommandError> {
    let mut trials = Vec::with_capacity(arguments.trials as usize);
    for seed in 1..=arguments.trials {
        let setup =
            TrialSetup { inputs, seed, threads: arguments.threads.count(), check: arguments.check };
        bar.set_message(format!("{} seed {seed}", inputs.scenario.name));
        let key = setup.key(program);
        trials.push(journal.find_or_make(&key, arguments.check, || setup.run(program))?);
        bar.inc(1);
    }
    Ok(trials)
}

/// Shown only on a terminal; drawn between trials, never during one.
fn progress_bar(length: u64) -> ProgressBar {
    let target = if terminal::is_watched() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let style = ProgressStyle::with_template(
        "{bar:30} {pos}/{len} trials, {elapsed} of about {duration}  {wide_msg}",
    );
    ProgressBar::with_draw_target(Some(length), target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The worst outcome of the rows.
fn command_outcome(rows: &[&Row]) -> CommandOutcome {
    if rows.iter().any(|row| row.refused > 0) {
        CommandOutcome::Refused
    } else if rows.iter().any(|row| row.found < row.trials) {
        CommandOutcome::NoPlan
    } else {
        CommandOutcome::Done
    }
}
