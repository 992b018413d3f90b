//! `surefoot export`: an exported plan in the formats of other programs.

use crate::cli::arguments::{ExportArguments, OutputArguments};
use crate::export::{ExportMotion, ExportOptions, export};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Runs the command. Robot and world are those that the plan names.
///
/// # Errors
/// An option is missing, the plan, its robot or its world cannot be used, or the file cannot be
/// written.
pub fn run(arguments: &ExportArguments) -> Result<CommandOutcome, CommandError> {
    let options = ExportOptions {
        format: arguments.to,
        hz: arguments.hz,
        joints: arguments.joint_order.clone(),
        quaternion: arguments.quat,
        bodies: arguments.bodies.clone(),
    };
    options.check()?;
    let outputs =
        OutputArguments { export: Some(arguments.out.clone()), ..OutputArguments::default() };
    output_files::check(&outputs, std::slice::from_ref(&arguments.plan))?;
    let motion = ExportMotion::load(&arguments.plan)?;
    output_files::write(&export(&motion, &options)?, &arguments.out)?;
    Ok(CommandOutcome::Done)
}
