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
    let text = std::fs::read_to_string(path)
        .map_err(|error| InputError::file(path, format!("cannot be read: {error}")))?;
    let value: serde_json::Value = match serde_json::from_str(&text) {
        Ok(value) => value,
        // Reading it as a plan says which kind of file it is instead.
        Err(error) => {
            load_plan(path)?;
            return Err(InputError::file(path, format!("is not JSON: {error}")).into());
        }
    };
    let lines = if value.get("schema").is_some() {
        plan_facts::lines(&load_plan(path)?, path)?
    } else {
        report_facts::lines(&value).ok_or_else(|| {
            InputError::file(
                path,
                "is neither a plan nor a report; 'surefoot walk --export' writes the one, \
                 '--json' the other",
            )
        })?
    };
    terminal::print_result(&lines.join("\n"));
    Ok(CommandOutcome::Done)
}
