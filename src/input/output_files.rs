//! The files that a run writes. Their paths are checked before the run; each is written completely
//! or not at all.

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use serde::Serialize;
use surefoot_shared_types::plan_format::blocks::PlanFile;
use surefoot_shared_types::robot::load::robot_from_block;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::world_from_block;
use surefoot_shared_types::world::world::World;

use crate::cli::arguments::OutputArguments;
use crate::input::inputs::Inputs;
use crate::picture::PictureScene;
use crate::picture::render::{check_extension, render};
use crate::report::command_error::CommandError;

/// Checks that every requested file can be written, so that a long run does not fail at its end.
///
/// # Errors
/// A folder is missing or cannot be written to, a path is a folder, a device or a link, two paths
/// are equal, or a picture's extension is unknown.
pub fn check(outputs: &OutputArguments) -> Result<(), CommandError> {
    if let Some(picture) = &outputs.picture {
        check_extension(picture)?;
    }
    let paths: Vec<&PathBuf> =
        [&outputs.export, &outputs.picture, &outputs.json].into_iter().flatten().collect();
    paths.iter().try_for_each(|path| check_path(path))?;
    check_distinct(&paths)
}

/// Refuses two paths of the same file.
fn check_distinct(paths: &[&PathBuf]) -> Result<(), CommandError> {
    let location = |path: &Path| {
        (folder_of(path).canonicalize().ok(), path.file_name().map(std::ffi::OsStr::to_owned))
    };
    let is_repeated = |index: &usize| {
        paths[..*index].iter().any(|before| location(before) == location(paths[*index]))
    };
    match (0..paths.len()).find(is_repeated) {
        Some(index) => {
            Err(unwritable(paths[index], "two outputs have this path; use different paths"))
        }
        None => Ok(()),
    }
}

/// Draws a plan.
///
/// # Errors
/// The plan cannot be drawn or the file cannot be written.
pub fn draw(inputs: &Inputs, plan: &PlanFile, path: &Path) -> Result<(), CommandError> {
    let scene = PictureScene::new(&inputs.model, &inputs.world, plan)?;
    Ok(render(&scene, path)?)
}

/// The robot and the world that an exported plan names, by paths relative to its file.
///
/// # Errors
/// One of them cannot be used.
pub fn robot_and_world(
    plan: &PlanFile,
    plan_path: &Path,
) -> Result<(RobotModel, World), CommandError> {
    let base_dir = plan_path.parent().unwrap_or(Path::new(""));
    let model = robot_from_block(&plan.robot, base_dir, plan_path)?;
    Ok((model, world_from_block(&plan.scene, base_dir, plan_path)?))
}

/// Checks that files can be written into a folder.
///
/// # Errors
/// It is missing or cannot be written to.
pub fn check_folder(folder: &Path) -> Result<(), CommandError> {
    if !folder.is_dir() {
        return Err(unwritable(folder, "the folder does not exist; create it first"));
    }
    check_path(&folder.join("a file"))
}

/// Writes a text file.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(text: &str, path: &Path) -> Result<(), CommandError> {
    let failed = |error: std::io::Error| unwritable(path, &error.to_string());
    let mut file = temporary_beside(path).map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    file.persist(path).map(drop).map_err(|error| failed(error.error))
}

/// Writes a value as a JSON file.
///
/// # Errors
/// The file cannot be written.
pub fn write_json(value: &impl Serialize, path: &Path) -> Result<(), CommandError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| unwritable(path, &error.to_string()))?;
    write_text(&format!("{text}\n"), path)
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> PathBuf {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .map_or_else(|| PathBuf::from("."), Path::to_owned)
}

fn check_path(path: &Path) -> Result<(), CommandError> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(unwritable(path, "it is a folder; name a file in it"));
    }
    if !folder_of(path).is_dir() {
        return Err(unwritable(path, "its folder does not exist; create it first"));
    }
    if std::fs::symlink_metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(unwritable(path, "it exists and is not a regular file; choose another name"));
    }
    temporary_beside(path)
        .map(drop)
        .map_err(|error| unwritable(path, &format!("{error}; choose another folder")))
}

fn temporary_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    // The permissions of an ordinary new file; the process's mask still applies.
    let readable = Permissions::from_mode(0o666);
    tempfile::Builder::new()
        .prefix(".surefoot-")
        .suffix(".tmp")
        .permissions(readable)
        .tempfile_in(folder_of(path))
}

fn unwritable(path: &Path, reason: &str) -> CommandError {
    CommandError::Output { path: path.to_owned(), reason: reason.to_owned() }
}
