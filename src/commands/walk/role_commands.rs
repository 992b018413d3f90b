//! The command lines of the planner and the controller process of a walk.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::cli::arguments::WalkArguments;
use crate::commands::walk::role_files::RoleFiles;
use crate::input::inputs::Inputs;
use crate::input::shipped::world_path;
use crate::report::command_error::CommandError;
use crate::report::role::Role;
use crate::system::cores::cores_of_roles;

/// This program, also if its file was replaced or removed since it was started: both roles and
/// their supervisor exchange messages that only one program knows.
const PROGRAM: &str = "/proc/self/exe";

/// The inputs of both command lines.
pub(crate) struct RoleCommands<'a> {
    pub(crate) inputs: &'a Inputs,
    /// The instance's name.
    pub(crate) instance: &'a str,
    pub(crate) arguments: &'a WalkArguments,
    /// The files that the roles get from this process.
    pub(crate) files: &'a RoleFiles,
}

impl RoleCommands<'_> {
    /// The command line of a role's process.
    ///
    /// # Errors
    /// The path of this program or of a file cannot be determined.
    pub(crate) fn command_of(&self, role: Role) -> Result<Command, CommandError> {
        match role {
            Role::Controller => self.controller(),
            Role::Planner => self.planner(),
        }
    }

    fn controller(&self) -> Result<Command, CommandError> {
        let role = Role::Controller;
        let core = cores_of_roles(self.arguments.search.threads()).1;
        let mut command = self.command("control", role, core)?;
        let simulation = &self.arguments.simulation;
        let world = simulation.ground_truth.as_deref().map(world_path).transpose()?;
        let files =
            [("--ground-truth", world.as_deref()), ("--executed", simulation.executed.as_deref())];
        for (option, path) in files {
            let Some(path) = path else { continue };
            let path =
                std::path::absolute(path).map_err(|source| CommandError::Start { role, source })?;
            command.arg(option_with_path(option, &path));
        }
        if let Some(rate) = simulation.rate {
            command.arg("--rate").arg(rate.to_string());
        }
        if let Some(seed) = simulation.disturb {
            command.arg("--disturb").arg(seed.to_string());
        }
        if let Some(late) = simulation.late {
            command.arg("--late").arg(format!("{}:{}", late.seed, late.share));
        }
        Ok(command)
    }

    fn planner(&self) -> Result<Command, CommandError> {
        let search = &self.arguments.search;
        let threads = search.threads();
        let mut command = self.command("plan", Role::Planner, cores_of_roles(threads).0)?;
        command.arg("--threads").arg(threads.to_string());
        command.arg("--improve").arg(search.improve.to_string());
        command.arg("--replans-max").arg(search.replans_max.to_string());
        if search.lock_memory {
            command.arg("--lock-memory");
        }
        let outputs = &self.arguments.outputs;
        if let Some(picture) = &outputs.picture {
            command.arg(option_with_path("--picture", picture));
        }
        match (self.files.plan_descriptor(), &outputs.export) {
            (Some(number), _) => {
                command.arg("--plan-descriptor").arg(number.to_string());
            }
            (None, Some(export)) => {
                command.arg(option_with_path("--export", export));
            }
            (None, None) => {}
        }
        Ok(command)
    }

    /// The part that both command lines have in common.
    fn command(
        &self,
        subcommand: &str,
        role: Role,
        core: Option<usize>,
    ) -> Result<Command, CommandError> {
        let failed = |source| CommandError::Start { role, source };
        let piped = self.files.scenario().map_err(failed)?;
        let scenario = match &piped {
            Some(_) => PathBuf::from("-"),
            None => std::path::absolute(&self.inputs.scenario.path).map_err(failed)?,
        };
        let mut command = Command::new(PROGRAM);
        command.arg0("surefoot").stdin(piped.unwrap_or_else(Stdio::null));
        command.arg(subcommand).arg(scenario).arg("--report-lines");
        command.arg("--instance").arg(self.instance);
        command.arg("--seed").arg(self.inputs.scenario.seed.to_string());
        command.arg("--motion").arg(self.inputs.scenario.execution.motion.name());
        if let Some(core) = core {
            command.arg("--core").arg(core.to_string());
        }
        Ok(command)
    }
}

/// `--option=path` as one argument, so that a path that begins with `-` is not read as an option.
fn option_with_path(option: &str, path: &Path) -> OsString {
    let mut argument = OsString::from(option);
    argument.push("=");
    argument.push(path);
    argument
}
