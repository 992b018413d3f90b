//! `surefoot completions`: what a shell needs to complete the command line.

use crate::cli::arguments::{Arguments, CompletionsArguments};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// None.
pub fn run(arguments: &CompletionsArguments) -> Result<CommandOutcome, CommandError> {
    let mut script = Vec::new();
    let mut command = Arguments::complete_command();
    clap_complete::generate(arguments.shell, &mut command, "surefoot", &mut script);
    terminal::print_result(String::from_utf8_lossy(&script).trim_end());
    Ok(CommandOutcome::Done)
}
