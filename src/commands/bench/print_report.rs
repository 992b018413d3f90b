//! Prints what a bench measured.

use serde::Serialize;

use crate::report::command_error::CommandError;
use crate::system::terminal;

/// Prints a report as JSON, or else its text.
///
/// # Errors
/// When the report cannot be written as JSON.
pub fn print_report(
    report: &impl Serialize,
    is_json: bool,
    text: impl FnOnce() -> String,
) -> Result<(), CommandError> {
    let text = if is_json { json(report)? } else { text() };
    terminal::print_result(&text);
    Ok(())
}

fn json(report: &impl Serialize) -> Result<String, CommandError> {
    serde_json::to_string_pretty(report)
        .map_err(|error| CommandError::Output { path: "stdout".into(), reason: error.to_string() })
}
