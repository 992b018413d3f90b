//! `surefoot robot inspect`: a robot as it is read.

use std::path::Path;

use surefoot_planner::PlannerError;
use surefoot_planner::collision::model::CollisionModel;
use surefoot_shared_types::base::text_file::folder_of;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::{load_robot, robot_from_text};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::robot_draft::text::{ROBOT_FILE, robot_file};
use surefoot_shared_types::robot_draft::{DraftOptions, RobotDraft};

use crate::cli::arguments::OutputArguments;
use crate::cli::robot_arguments::RobotInspectArguments;
use crate::commands::robot::inspect_text::{json, text};
use crate::commands::robot::trial::level_ground;
use crate::input::output_files;
use crate::input::shipped::robot_path;
use crate::picture::PictureScene;
use crate::picture::render::render;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// The robot cannot be used, or the picture cannot be written.
pub fn run(arguments: &RobotInspectArguments) -> Result<CommandOutcome, CommandError> {
    let outputs =
        OutputArguments { picture: arguments.picture.clone(), ..OutputArguments::default() };
    output_files::check(&outputs, std::slice::from_ref(&arguments.robot))?;
    let model = load(&arguments.robot)?;
    let allowed = allowed_pairs(&model)?;
    if let Some(picture) = &arguments.picture {
        render(&PictureScene::of_robot(&model, &level_ground())?, picture)?;
    }
    let shown = if arguments.json { json(&model, &allowed) } else { text(&model, &allowed) };
    terminal::print_result(&shown);
    Ok(CommandOutcome::Done)
}

/// The robot of a robot file, of a folder that holds one, of a URDF alone, or of a shipped robot's
/// name.
fn load(path: &Path) -> Result<RobotModel, CommandError> {
    let path = robot_path(path)?;
    let is_urdf = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
    if !is_urdf {
        return Ok(load_robot(&path)?);
    }
    let draft = RobotDraft::from_urdf(&path, &DraftOptions::default())?;
    let text = robot_file(&draft, &folder_of(&path));
    Ok(robot_from_text(text, &path.with_file_name(ROBOT_FILE))?)
}

/// The pairs of links that may touch, by the planner's rule.
fn allowed_pairs(model: &RobotModel) -> Result<Vec<[String; 2]>, CommandError> {
    let clearance = PlannerConfig::default().clearance;
    let collision =
        CollisionModel::new(model, &level_ground(), clearance).map_err(PlannerError::from)?;
    let name = |link: usize| model.links[link].name.clone();
    Ok(collision.allowed_pairs().iter().map(|(a, b)| [name(*a), name(*b)]).collect())
}
