//! `surefoot new`: a first scenario to change.

use std::path::Path;

use surefoot_shared_types::base::text_file::relative_path;
use surefoot_shared_types::robot::load::load_robot;

use crate::cli::arguments::NewArguments;
use crate::input::output_files::write_text;
use crate::input::shipped::{bytes_of, robot_path};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// The shipped robot, which the scenario uses.
const ROBOT: [&str; 2] = ["robot.toml", "hubo.urdf"];
/// The start of the line that names the robot.
const SHIPPED_LINE: &str = "robot = \"robot/robot.toml\"";
/// The lateral distance between the soles of the shipped robot.
const SHIPPED_WIDTH: &str = "stance_width = 0.2";
const SCENARIO: &str = include_str!("new/scenario.toml");
const WORLD: &str = include_str!("new/world.toml");

/// Runs the command. Existing files stay.
///
/// # Errors
/// One of the files exists, or the folder cannot be written to.
pub fn run(arguments: &NewArguments) -> Result<CommandOutcome, CommandError> {
    let folder = &arguments.folder;
    let mut files = vec![("world.toml".to_owned(), WORLD.to_owned())];
    let (made, also) = match &arguments.robot {
        Some(robot) => {
            files.push(("scenario.toml".to_owned(), scenario_of(robot, folder)?));
            (folder.clone(), " and world.toml")
        }
        None => {
            files.push(("scenario.toml".to_owned(), SCENARIO.to_owned()));
            files.extend(shipped_robot());
            (folder.join("robot"), ", world.toml and robot/")
        }
    };
    for (name, _) in &files {
        let path = folder.join(name);
        if path.symlink_metadata().is_ok() {
            return Err(output_error(&path, "it exists; choose a new folder"));
        }
    }
    std::fs::create_dir_all(&made)
        .map_err(|error| output_error(&made, &format!("{error}; choose another folder")))?;
    files.iter().try_for_each(|(name, text)| write_text(text, &folder.join(name)))?;
    let scenario = folder.join("scenario.toml");
    terminal::print_result(&format!(
        "wrote {0}{also}\nnext: surefoot walk {0} --picture walk.png",
        scenario.display()
    ));
    Ok(CommandOutcome::Done)
}

/// The files of the shipped robot.
fn shipped_robot() -> impl Iterator<Item = (String, String)> {
    ROBOT.iter().map(|name| {
        let bytes = bytes_of(&format!("robots/hubo/{name}")).unwrap_or_default();
        (format!("robot/{name}"), String::from_utf8_lossy(bytes).into_owned())
    })
}

/// The scenario with another robot, named relative to `folder`.
fn scenario_of(robot: &Path, folder: &Path) -> Result<String, CommandError> {
    let robot = &robot_path(robot)?;
    let model = load_robot(robot)?;
    let width = (100.0 * model.stance_width()).round() / 100.0;
    let path = relative_path(robot, folder);
    let quoted =
        serde_json::to_string(&path).map_err(|error| output_error(robot, &error.to_string()))?;
    let text = SCENARIO.replacen(SHIPPED_LINE, &format!("robot = {quoted}"), 1);
    Ok(text.replace(SHIPPED_WIDTH, &format!("stance_width = {width:.2}")))
}

fn output_error(path: &Path, reason: &str) -> CommandError {
    CommandError::Output { path: path.to_owned(), reason: reason.to_owned() }
}
