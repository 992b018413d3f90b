//! `surefoot man`: a manual page for each command.

use crate::cli::arguments::{Arguments, ManArguments};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// The folder cannot be made or written to.
pub fn run(arguments: &ManArguments) -> Result<CommandOutcome, CommandError> {
    let folder = &arguments.folder;
    let failed = |error: std::io::Error| CommandError::Output {
        path: folder.clone(),
        reason: format!("{error}; choose another folder"),
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    clap_mangen::generate_to(Arguments::complete_command(), folder).map_err(failed)?;
    terminal::print_result(&format!("man -l {}", folder.join("surefoot.1").display()));
    Ok(CommandOutcome::Done)
}
