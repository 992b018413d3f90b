//! `surefoot robot`: robots of one's own.

mod add;
mod add_summary;
mod exact_links;
mod inspect;
mod inspect_text;
mod made_folder;
pub(crate) mod trial;

use crate::cli::robot_arguments::RobotCommand;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Runs the command.
///
/// # Errors
/// The robot cannot be used, or a file cannot be written.
pub fn run(command: &RobotCommand) -> Result<CommandOutcome, CommandError> {
    match command {
        RobotCommand::Add(arguments) => add::run(arguments),
        RobotCommand::Inspect(arguments) => inspect::run(arguments),
    }
}
