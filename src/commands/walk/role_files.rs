//! The files that the supervisor hands on to the processes of the roles.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use surefoot_shared_types::base::whole_file;

use crate::cli::arguments::OutputArguments;
use crate::input::inputs::Inputs;
use crate::input::output_files;
use crate::report::command_error::CommandError;
use crate::system::memory_file;

/// Files in memory: the scenario, if it came from a pipe, and the plan, if the planner's process
/// cannot write it where it belongs.
#[derive(Debug)]
pub(crate) struct RoleFiles {
    scenario: Option<File>,
    plan: Option<File>,
}

impl RoleFiles {
    pub(crate) fn new(inputs: &Inputs, outputs: &OutputArguments) -> Result<Self, CommandError> {
        let scenario = inputs.piped_scenario.as_deref().map(memory_text).transpose();
        let plan = needs_plan(outputs).then(|| memory_file::create(true)).transpose();
        let failed = |error: io::Error| CommandError::Output {
            path: PathBuf::from("a file in memory"),
            reason: error.to_string(),
        };
        Ok(Self { scenario: scenario.map_err(failed)?, plan: plan.map_err(failed)? })
    }

    /// The standard input of a role, which reads the scenario there; `None` if it reads the file.
    pub(crate) fn scenario(&self) -> io::Result<Option<Stdio>> {
        let reopened = self.scenario.as_ref().map(memory_file::reopen);
        Ok(reopened.transpose()?.map(Stdio::from))
    }

    /// The inherited descriptor that the planner's process writes the plan to.
    pub(crate) fn plan_descriptor(&self) -> Option<i32> {
        self.plan.as_ref().map(AsRawFd::as_raw_fd)
    }

    /// Writes the plan where `outputs` name it, unless the planner's process has done so.
    pub(crate) fn write_plan(&self, outputs: &OutputArguments) -> Result<(), CommandError> {
        let (Some(plan), Some(path)) = (&self.plan, &outputs.export) else { return Ok(()) };
        let failed = |error: io::Error| CommandError::Output {
            path: path.clone(),
            reason: error.to_string(),
        };
        let mut text = Vec::new();
        memory_file::reopen(plan)
            .and_then(|mut file| file.read_to_end(&mut text))
            .map_err(failed)?;
        output_files::write(&text, path)
    }

    /// The file that holds the plan.
    pub(crate) fn plan_path(&self, outputs: &OutputArguments) -> Option<PathBuf> {
        let descriptor = self.plan_descriptor();
        let in_memory = descriptor.map(|number| PathBuf::from(format!("/proc/self/fd/{number}")));
        in_memory.or_else(|| outputs.export.clone())
    }
}

/// The folder that the paths in the plan refer to.
pub(crate) fn plan_folder(outputs: &OutputArguments) -> PathBuf {
    output_files::plan_folder(outputs.export.as_deref().unwrap_or(Path::new("-")))
}

/// Whether the planner's process has no file of its own for the plan: its standard output is not
/// the supervisor's, and the supervisor reads the plan that it draws.
fn needs_plan(outputs: &OutputArguments) -> bool {
    match &outputs.export {
        Some(path) => whole_file::is_stream(Path::new(path)),
        None => outputs.shows_plan(),
    }
}

fn memory_text(text: &str) -> io::Result<File> {
    let mut file = memory_file::create(false)?;
    file.write_all(text.as_bytes())?;
    Ok(file)
}
