//! `surefoot walk`: runs a planner process and a controller process, and prints a summary.

mod role_commands;

use std::path::{Path, PathBuf};

use surefoot_shared_types::instance::{Instance, Participant};
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::world::load::load_world;

use crate::cli::arguments::WalkArguments;
use crate::commands::session::write_report;
use crate::commands::walk::role_commands::RoleCommands;
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::RoleEvent;
use crate::report::progress::Progress;
use crate::report::run_report::Report;
use crate::report::summary;
use crate::supervisor::supervisor::Supervisor;
use crate::system::{signals, terminal};

/// Runs the command.
///
/// # Errors
/// An input cannot be used, an output cannot be written, a process fails, or a signal comes.
pub fn run(arguments: &WalkArguments) -> Result<CommandOutcome, CommandError> {
    let inputs = Inputs::load(&arguments.search.scenario, Overrides::of(&arguments.search))?;
    output_files::check(&arguments.outputs)?;
    if let Some(ground_truth) = &arguments.ground_truth {
        load_world(ground_truth)?;
    }
    inputs.preparation(arguments.outputs.quiet)?;
    signals::install();
    let export = Export::new(arguments)?;
    let mut report = Report::new(inputs.names(), arguments.search.threads());
    let json = arguments.outputs.json.as_deref();
    if let Err(error) = walk(arguments, &inputs, export.path.as_deref(), &mut report) {
        report.record_error(&error);
        if let (Some(path), Some(_)) = (json, error.name()) {
            output_files::write_json(&report, path)?;
        }
        return Err(error);
    }
    if let (Some(picture), Some(plan), true) =
        (&arguments.outputs.picture, &export.path, report.has_plan())
    {
        output_files::draw(&inputs, &load_plan(plan)?, picture)?;
    }
    let outcome = write_report(&report, json)?;
    terminal::print_result(&summary::text(&report));
    Ok(outcome)
}

/// The file that the planner process exports the plan to: the one that the user names, or a
/// temporary one for the picture.
struct Export {
    path: Option<PathBuf>,
    _folder: Option<tempfile::TempDir>,
}

impl Export {
    fn new(arguments: &WalkArguments) -> Result<Self, CommandError> {
        let outputs = &arguments.outputs;
        if outputs.export.is_some() || outputs.picture.is_none() {
            return Ok(Self { path: outputs.export.clone(), _folder: None });
        }
        let folder = tempfile::Builder::new().prefix("surefoot-picture-").tempdir();
        let folder = folder.map_err(|error| CommandError::Output {
            path: std::env::temp_dir(),
            reason: error.to_string(),
        })?;
        Ok(Self { path: Some(folder.path().join("plan.json")), _folder: Some(folder) })
    }
}

/// Runs both processes in an instance of their own until both have reported their results.
fn walk(
    arguments: &WalkArguments,
    inputs: &Inputs,
    export: Option<&Path>,
    report: &mut Report,
) -> Result<(), CommandError> {
    Instance::clean_dead()?;
    let instance = Instance::create(&format!("walk-{}", std::process::id()))?;
    // The node and the services exist before the roles start, and outlive a killed role.
    let participant = Participant::open(&instance)?;
    let _state = {
        let _making = participant.making()?;
        participant.open_state()?
    };
    let commands = RoleCommands { inputs, instance: instance.name(), arguments, export };
    let command_of = |role| commands.command_of(role);
    let mut progress = Progress::new(arguments.outputs.quiet);
    let mut on_event = |event: &RoleEvent| {
        report.record(event);
        progress.show(event);
    };
    let result = Supervisor::new(&command_of, &mut on_event, arguments.restarts_max).run();
    progress.clear();
    result
}
