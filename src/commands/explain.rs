//! `surefoot explain`: what a saved plan does, or why a search found none, in sentences.

mod plan_facts;
mod report_facts;

use surefoot_shared_types::InputError;
use surefoot_shared_types::plan_file::read::load_plan;

use crate::cli::arguments::ExplainArguments;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// The file is neither a plan nor a report, or the plan's robot or world cannot be used.
pub fn run(arguments: &ExplainArguments) -> Result<CommandOutcome, CommandError> {
    let path = &arguments.file;
    let report = std::fs::read_to_string(path)
        .ok()
        .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok())
        .filter(|value| value.get("schema").is_none());
    // Of any other file, loading it as a plan names the fault.
    let lines = match report {
        None => plan_facts::lines(&load_plan(path)?, path)?,
        Some(report) => report_facts::lines(&report).ok_or_else(|| {
            InputError::file(
                path,
                "is neither a plan nor a report; 'surefoot walk --export' writes the one, \
                 '--json' the other",
            )
        })?,
    };
    terminal::print_result(&lines.join("\n"));
    Ok(CommandOutcome::Done)
}
