//! `surefoot picture`: draws an exported plan.

use surefoot_shared_types::plan_file::read::{load_plan, robot_and_world};

use crate::cli::arguments::{OutputArguments, PictureArguments};
use crate::input::output_files;
use crate::picture::PictureScene;
use crate::picture::render::render;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Runs the command. Robot and world are those that the plan names.
///
/// # Errors
/// The plan, its robot or its world cannot be used, or the picture cannot be written.
pub fn run(arguments: &PictureArguments) -> Result<CommandOutcome, CommandError> {
    let outputs =
        OutputArguments { picture: Some(arguments.out.clone()), ..OutputArguments::default() };
    output_files::check(&outputs, std::slice::from_ref(&arguments.plan))?;
    let plan = load_plan(&arguments.plan)?;
    let (model, world) = robot_and_world(&plan, &arguments.plan)?;
    render(&PictureScene::new(&model, &world, &plan)?, &arguments.out)?;
    Ok(CommandOutcome::Done)
}
