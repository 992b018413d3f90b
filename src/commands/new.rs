//! `surefoot new`: a first scenario to change.

use std::path::Path;

use crate::cli::arguments::NewArguments;
use crate::input::output_files::write_text;
use crate::input::shipped::bytes_of;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// The shipped robot, which the scenario uses.
const ROBOT: [&str; 2] = ["robot.toml", "hubo.urdf"];
const SCENARIO: &str = include_str!("new/scenario.toml");
const WORLD: &str = include_str!("new/world.toml");

/// Runs the command. Existing files stay.
///
/// # Errors
/// One of the files exists, or the folder cannot be written to.
pub fn run(arguments: &NewArguments) -> Result<CommandOutcome, CommandError> {
    let folder = &arguments.folder;
    let mut files = vec![("scenario.toml".to_owned(), SCENARIO.to_owned())];
    files.push(("world.toml".to_owned(), WORLD.to_owned()));
    files.extend(ROBOT.iter().map(|name| {
        let bytes = bytes_of(&format!("robots/hubo/{name}")).unwrap_or_default();
        (format!("robot/{name}"), String::from_utf8_lossy(bytes).into_owned())
    }));
    for (name, _) in &files {
        let path = folder.join(name);
        if path.symlink_metadata().is_ok() {
            return Err(output_error(&path, "it exists; choose a new folder"));
        }
    }
    let robot = folder.join("robot");
    std::fs::create_dir_all(&robot)
        .map_err(|error| output_error(&robot, &format!("{error}; choose another folder")))?;
    files.iter().try_for_each(|(name, text)| write_text(text, &folder.join(name)))?;
    let scenario = folder.join("scenario.toml");
    terminal::print_result(&format!(
        "wrote {0}, world.toml and robot/\nnext: surefoot walk {0} --picture walk.png",
        scenario.display()
    ));
    Ok(CommandOutcome::Done)
}

fn output_error(path: &Path, reason: &str) -> CommandError {
    CommandError::Output { path: path.to_owned(), reason: reason.to_owned() }
}
