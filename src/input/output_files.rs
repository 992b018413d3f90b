//! The files that a run writes. Their paths are checked before the run; each is written completely
//! or not at all.

use std::path::{Path, PathBuf};

use serde::Serialize;
use surefoot_planner::pipeline::SearchTrace;
use surefoot_shared_types::base::whole_file;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::plan_file::read::robot_and_world;
use surefoot_shared_types::plan_file::write::{check_file_names, plan_from_chunks};
use surefoot_shared_types::plan_format::blocks::PlanFile;

use crate::cli::arguments::OutputArguments;
use crate::export::{ExportMotion, recording};
use crate::input::inputs::Inputs;
use crate::picture::PictureScene;
use crate::picture::render::{check_extension, render};
use crate::report::command_error::CommandError;
use crate::system::signals::{self, Activity};

/// Rate of the robot's state in a recording of `--record`, Hz.
const RECORDING_HZ: f64 = 50.0;

/// Endings of files that are no JSON.
const OTHER_ENDINGS: [&str; 9] =
    ["png", "apng", "mcap", "csv", "npz", "toml", "urdf", "rrd", "xml"];

/// Checks that every requested file can be written, so that a long run does not fail at its end.
///
/// # Errors
/// As [`check`]; also if a name ends as that of another kind of file, or the plan would name one of
/// its inputs by a path that is no text.
pub fn check_run(outputs: &OutputArguments, inputs: &Inputs) -> Result<(), CommandError> {
    check(outputs, &inputs.files())?;
    check_endings(outputs)?;
    match &outputs.export {
        Some(path) => check_plan_names(path, inputs),
        None => Ok(()),
    }
}

/// Checks that every requested file can be written, and that none is one of `inputs`.
///
/// # Errors
/// A folder is missing or cannot be written to, a path is a folder or write-protected, two paths
/// name one file, a path names an input, or a picture's extension is unknown.
pub fn check(outputs: &OutputArguments, inputs: &[PathBuf]) -> Result<(), CommandError> {
    if let Some(picture) = &outputs.picture {
        check_extension(picture)?;
    }
    let paths: Vec<&PathBuf> = outputs.paths().collect();
    paths.iter().try_for_each(|path| check_path(path))?;
    check_distinct(&paths, inputs)
}

/// Refuses names whose ending is that of another kind of file.
fn check_endings(outputs: &OutputArguments) -> Result<(), CommandError> {
    let ending = |path: &Path| path.extension().map(|ending| ending.to_ascii_lowercase());
    for path in [&outputs.export, &outputs.json].into_iter().flatten() {
        let found = ending(path).unwrap_or_default();
        if let Some(other) = OTHER_ENDINGS.iter().find(|other| found == **other) {
            return Err(unwritable(
                path,
                &format!("JSON is written, and .{other} is not its ending"),
            ));
        }
    }
    match outputs.record.as_deref().filter(|path| !whole_file::is_stream(path)) {
        Some(path) if ending(path).is_none_or(|ending| ending != "mcap") => {
            Err(unwritable(path, "the name of a recording must end in .mcap"))
        }
        _ => Ok(()),
    }
}

/// Checks that a plan can be written to a path that is neither one of the other outputs nor an
/// input.
///
/// # Errors
/// As [`check_run`]; also if the path is no file of its own.
pub fn check_other(
    path: &PathBuf,
    outputs: &OutputArguments,
    inputs: &Inputs,
) -> Result<(), CommandError> {
    check_path(path)?;
    if whole_file::is_stream(path) {
        return Err(unwritable(path, "a file is needed"));
    }
    let paths: Vec<&PathBuf> = outputs.paths().chain([path]).collect();
    check_distinct(&paths, &inputs.files())?;
    check_plan_names(path, inputs)
}

/// Refuses two paths of the same file, and a path of an input.
fn check_distinct(outputs: &[&PathBuf], inputs: &[PathBuf]) -> Result<(), CommandError> {
    let inputs: Vec<PathBuf> =
        inputs.iter().filter_map(|path| whole_file::target_of(path)).collect();
    for (index, path) in outputs.iter().enumerate() {
        let Some(target) = whole_file::target_of(path) else { continue };
        let is_same = |other: &&PathBuf| whole_file::target_of(other).as_ref() == Some(&target);
        if outputs[..index].iter().any(is_same) {
            return Err(unwritable(path, "two outputs have this path; use different paths"));
        }
        if inputs.contains(&target) {
            return Err(unwritable(path, "it is a file that this run reads; use another path"));
        }
    }
    Ok(())
}

fn check_plan_names(path: &Path, inputs: &Inputs) -> Result<(), CommandError> {
    let plan =
        plan_from_chunks(&inputs.model, &inputs.world, &inputs.scenario, &[], &plan_folder(path));
    check_file_names(&plan).map_err(|(element, message)| {
        unwritable(path, &format!("a plan file cannot name its inputs: {element}: {message}"))
    })
}

/// Draws and records a plan, as far as `outputs` ask for it. The plan's paths are relative to
/// `folder`.
///
/// # Errors
/// The plan cannot be drawn or recorded, a file cannot be written, or a signal comes.
pub fn show_plan(
    inputs: &Inputs,
    plan: &PlanFile,
    folder: &Path,
    outputs: &OutputArguments,
) -> Result<(), CommandError> {
    if let Some(picture) = &outputs.picture {
        draw(inputs, plan, picture)?;
    }
    match &outputs.record {
        Some(path) => record(plan, folder, path),
        None => Ok(()),
    }
}

/// Records a plan. Its robot is read again: in a plan file the root is the URDF's.
fn record(plan: &PlanFile, folder: &Path, path: &Path) -> Result<(), CommandError> {
    let plan_path = folder.join("plan.json");
    let (model, world) = robot_and_world(plan, &plan_path)?;
    let motion = ExportMotion::new(plan, &plan_path, model, world)?;
    write(&recording::write(&motion, RECORDING_HZ)?, path)
}

/// Draws a plan.
///
/// # Errors
/// The plan cannot be drawn or the file cannot be written, or a signal comes.
pub fn draw(inputs: &Inputs, plan: &PlanFile, path: &Path) -> Result<(), CommandError> {
    signals::set_activity(Activity::Drawing);
    CommandError::unless_interrupted()?;
    let scene = PictureScene::new(&inputs.model, &inputs.world, plan)?;
    render(&scene, path)?;
    signals::set_activity(Activity::Other);
    Ok(())
}

/// Draws a search that found no plan.
///
/// # Errors
/// As [`draw`].
pub fn draw_search(
    inputs: &Inputs,
    scenario: &Scenario,
    trace: &SearchTrace,
    path: &Path,
) -> Result<(), CommandError> {
    signals::set_activity(Activity::Drawing);
    CommandError::unless_interrupted()?;
    let scene = PictureScene::of_search(&inputs.model, &inputs.world, scenario, trace)?;
    render(&scene, path)?;
    signals::set_activity(Activity::Other);
    Ok(())
}

/// Checks that files can be written into a folder, if one is named.
///
/// # Errors
/// It is missing or cannot be written to.
pub fn check_folder(folder: Option<&Path>) -> Result<(), CommandError> {
    let Some(folder) = folder else { return Ok(()) };
    if !folder.is_dir() {
        return Err(unwritable(folder, "the folder does not exist; create it first"));
    }
    check_path(&folder.join("a file"))
}

/// Writes a file. A signal during the write of a regular file is recorded; one during the write of
/// a pipe or device ends the process.
///
/// # Errors
/// The file cannot be written.
pub fn write(bytes: &[u8], path: &Path) -> Result<(), CommandError> {
    let is_stream = whole_file::is_stream(path);
    let _deferral = (!is_stream).then(signals::defer);
    // A reader of a pipe may be slow for ever.
    let _exposure = is_stream.then(signals::expose);
    signals::set_activity(Activity::Writing);
    let written = whole_file::write(path, bytes).map_err(|reason| unwritable(path, &reason));
    signals::set_activity(Activity::Other);
    written
}

/// Writes a text file.
///
/// # Errors
/// The file cannot be written.
pub fn write_text(text: &str, path: &Path) -> Result<(), CommandError> {
    write(text.as_bytes(), path)
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

/// The folder that the paths in a plan file refer to: the file's, for a stream the working folder.
pub fn plan_folder(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if !whole_file::is_stream(path) => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Whether a run writes one of its files to the standard output, which its summary leaves then.
pub fn use_standard_output(outputs: &OutputArguments) -> bool {
    outputs.paths().any(|path| whole_file::is_standard_output(path))
}

/// Checks that a file can be written.
///
/// # Errors
/// Its folder is missing or cannot be written to, or it is a folder or write-protected.
pub fn check_path(path: &Path) -> Result<(), CommandError> {
    whole_file::check(path).map_err(|reason| unwritable(path, &reason))
}

fn unwritable(path: &Path, reason: &str) -> CommandError {
    CommandError::Output { path: path.to_owned(), reason: reason.to_owned() }
}
