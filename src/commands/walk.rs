//! `surefoot walk`: runs a planner process and a controller process, and prints a summary.

mod role_commands;
mod role_files;

use surefoot_shared_types::instance::{Instance, Participant};
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::world::load::load_world;

use crate::cli::arguments::WalkArguments;
use crate::commands::session::{FinishArguments, finish};
use crate::commands::walk::role_commands::RoleCommands;
use crate::commands::walk::role_files::{RoleFiles, plan_folder};
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::input::shipped::world_path;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::RoleEvent;
use crate::report::progress::Progress;
use crate::report::run_report::Report;
use crate::supervisor::supervisor::Supervisor;
use crate::system::instance::create_own_instance;
use crate::system::signals;

/// Runs the command.
///
/// # Errors
/// An input cannot be used, an output cannot be written, a process fails, or a signal comes.
pub fn run(arguments: &WalkArguments) -> Result<CommandOutcome, CommandError> {
    let inputs = Inputs::load(&arguments.search.scenario, Overrides::of(&arguments.search))?;
    output_files::check_run(&arguments.outputs, &inputs)?;
    let simulation = &arguments.simulation;
    if let Some(executed) = &simulation.executed {
        output_files::check_other(executed, &arguments.outputs, &inputs)?;
    }
    if let Some(ground_truth) = &simulation.ground_truth {
        load_world(&world_path(ground_truth)?)?;
    }
    inputs.preparation(arguments.outputs.quiet)?;
    let mut report = Report::new(inputs.names(), arguments.search.threads());
    let deferral = signals::defer();
    let files = RoleFiles::new(&inputs, &arguments.outputs)?;
    let walked = walk(arguments, &inputs, &files, &mut report);
    let walked = walked.and_then(|()| match report.has_plan() {
        true => files.write_plan(&arguments.outputs),
        false => Ok(()),
    });
    drop(deferral);
    let has_plan = report.has_plan();
    let end = FinishArguments { outputs: &arguments.outputs, is_role: false };
    finish(&mut report, end, walked, || {
        let outputs = &arguments.outputs;
        let plan = files.plan_path(outputs).filter(|_| has_plan && outputs.shows_plan());
        plan.map_or(Ok(()), |plan| {
            let folder = plan_folder(outputs);
            output_files::show_plan(&inputs, &load_plan(&plan)?, &folder, outputs)
        })
    })
}

/// Runs both processes in an instance of their own until both have reported their results.
fn walk(
    arguments: &WalkArguments,
    inputs: &Inputs,
    files: &RoleFiles,
    report: &mut Report,
) -> Result<(), CommandError> {
    CommandError::unless_limited()?;
    Instance::clean_dead()?;
    let instance = match &arguments.instance {
        Some(name) => Instance::create(name)?,
        None => create_own_instance("walk")?,
    };
    // The node and the services exist before the roles start, and outlive a killed role.
    let participant = Participant::open(&instance)?;
    let _services = {
        let _making = participant.making()?;
        (participant.open_state()?, participant.open_description()?)
    };
    let commands = RoleCommands { inputs, instance: instance.name(), arguments, files };
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
