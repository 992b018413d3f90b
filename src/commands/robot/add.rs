//! `surefoot robot add`: writes the robot file of a URDF, once a walk on level ground shows that it
//! works.

use std::path::{Path, PathBuf};

use surefoot_shared_types::InputError;
use surefoot_shared_types::base::text_file::folder_of;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::robot_draft::text::{ROBOT_FILE, robot_file};
use surefoot_shared_types::robot_draft::{DraftOptions, RobotDraft};

use crate::cli::robot_arguments::{Package, RobotAddArguments};
use crate::commands::robot::add_summary::summary;
use crate::commands::robot::exact_links::with_exact_links;
use crate::commands::robot::made_folder::MadeFolder;
use crate::commands::robot::trial::{self, Trial};
use crate::input::output_files::write_text;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::signals::{self, Activity};
use crate::system::terminal;

/// Bends of the knees that are tried where the first one leads to no walk, rad.
const OTHER_BENDS: [f64; 2] = [0.8, 0.3];

/// Runs the command. Nothing is written unless the robot can be used; where no first walk is found,
/// the outcome says so.
///
/// # Errors
/// The URDF cannot be used, its feet cannot be distinguished, the robot cannot stand, or the file
/// exists or cannot be written.
pub fn run(arguments: &RobotAddArguments) -> Result<CommandOutcome, CommandError> {
    check_is_file(&arguments.urdf)?;
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => default_folder(&arguments.urdf)?,
    };
    let path = folder.join(ROBOT_FILE);
    check_free(&path)?;
    let mut made = MadeFolder::new(&folder)?;
    let mut tried = try_bend(arguments, &path, None)?;
    for bend in OTHER_BENDS {
        if !tried.trial.is_found() {
            let other = try_bend(arguments, &path, Some(bend))?;
            tried = if other.trial.is_found() { other } else { tried };
        }
    }
    let Tried { draft, text, model, trial } = tried;
    write_text(&text, &path)?;
    made.keep();
    terminal::print_result(&summary(&draft, &model, &trial, &folder));
    Ok(if trial.is_found() { CommandOutcome::Done } else { CommandOutcome::NoPlan })
}

/// A draft, and what a first walk with it shows.
struct Tried {
    draft: RobotDraft,
    text: String,
    model: RobotModel,
    trial: Trial,
}

/// Drafts the robot file that will stand at `path`, and walks with it.
fn try_bend(
    arguments: &RobotAddArguments,
    path: &Path,
    knee_bend: Option<f64>,
) -> Result<Tried, CommandError> {
    signals::set_activity(Activity::Reading);
    let feet = arguments.feet.as_ref().map(|feet| feet.0.clone());
    let skip_missing_meshes = arguments.skip_missing_meshes;
    let packages = arguments.packages.iter().map(|Package(name, at)| (name.clone(), at.clone()));
    let packages = packages.collect();
    let options = DraftOptions { feet, knee_bend, skip_missing_meshes, packages };
    let draft = RobotDraft::from_urdf(&arguments.urdf, &options)?;
    let (draft, model) = with_exact_links(draft, path)?;
    let text = robot_file(&draft, &folder_of(path));
    signals::set_activity(Activity::Other);
    CommandError::unless_interrupted()?;
    let trial = trial::run(&model, arguments.quiet)?;
    Ok(Tried { draft, text, model, trial })
}

/// Refuses a folder, which has the name of the folder that would be written.
fn check_is_file(urdf: &Path) -> Result<(), CommandError> {
    match urdf.is_dir() {
        true => Err(InputError::file(urdf, "is a folder; name the URDF in it").into()),
        false => Ok(()),
    }
}

/// A folder with the URDF's name, in the working folder.
fn default_folder(urdf: &Path) -> Result<PathBuf, CommandError> {
    match urdf.file_stem() {
        Some(stem) => Ok(PathBuf::from(stem)),
        None => Err(CommandError::Usage("name a URDF file, or a folder with --out".to_owned())),
    }
}

fn check_free(path: &Path) -> Result<(), CommandError> {
    let refuse = |path: &Path, reason: &str| {
        Err(CommandError::Output { path: path.to_owned(), reason: reason.to_owned() })
    };
    if path.symlink_metadata().is_ok() {
        return refuse(path, "it exists; remove it, or choose another folder with --out");
    }
    match path.parent() {
        Some(folder) if folder.exists() && !folder.is_dir() => {
            refuse(folder, "it is no folder; choose another one with --out")
        }
        _ => Ok(()),
    }
}
