//! The commands, one file each.

use crate::commands::bench::command;
use crate::commands::check;
use crate::commands::control;
use crate::commands::doctor;
use crate::commands::monitor;
use crate::commands::plan;
use crate::commands::prepare;
use crate::commands::request;
use crate::commands::walk;
use std::path::Path;

use surefoot_shared_types::instance::instance::{Instance, InstanceError};

use crate::cli::arguments::{Arguments, Command, RoleArguments};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::RoleEvent;
use crate::report::reporter::Reporter;
use crate::report::run_report::Report;
use crate::system::cores;
use crate::system::signals;
use crate::system::terminal;

/// How often entering an instance is tried while another process creates or leaves it.
const ENTER_ATTEMPTS_MAX: usize = 5;

/// Runs a command; answers its exit code.
pub fn run(arguments: &Arguments) -> u8 {
    let result = match &arguments.command {
        Command::Walk(arguments) => walk::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Control(arguments) => control::run(arguments),
        Command::Request(arguments) => request::run(arguments),
        Command::Monitor(arguments) => monitor::run(arguments),
        Command::Prepare(arguments) => prepare::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Bench(arguments) => command::run(arguments),
        Command::Doctor(arguments) => doctor::run(arguments),
    };
    match result {
        Ok(_) if terminal::has_lost_output() => {
            terminal::print_error(&CommandError::ResultNotPrinted);
            CommandError::ResultNotPrinted.code()
        }
        Ok(outcome) => outcome.code(),
        Err(error) => {
            report_error(&error, arguments.reports_lines());
            error.code()
        }
    }
}

/// Reports why a command ended with an error: to the supervisor, or on the terminal.
fn report_error(error: &CommandError, to_supervisor: bool) {
    match error {
        CommandError::Interrupted(_) | CommandError::ReportsClosed(_) if to_supervisor => {}
        _ if to_supervisor => {
            let emitted =
                Reporter::Supervisor.emit(&RoleEvent::Failed { message: error.to_string() });
            emitted.unwrap_or_else(|closed| terminal::print_error(&closed));
        }
        _ => terminal::print_error(error),
    }
}

/// What a process does first that may be a supervisor's.
pub(crate) fn prepare_process(role: &RoleArguments) {
    if role.report_lines {
        signals::end_with_parent();
    }
    signals::install();
    cores::pin(role.core);
}

/// Enters an instance, creating it where it does not exist yet.
pub(crate) fn enter_instance(name: &str) -> Result<Instance, InstanceError> {
    let mut attempts = 0;
    loop {
        attempts += 1;
        let entered = match Instance::attach(name) {
            Err(InstanceError::Missing { .. }) => Instance::create(name),
            entered => entered,
        };
        match entered {
            Err(InstanceError::InUse { .. }) if attempts < ENTER_ATTEMPTS_MAX => {}
            entered => return entered,
        }
    }
}

/// Writes the report where it is wanted; answers how the command ends.
pub(crate) fn write_report(
    report: &Report,
    json: Option<&Path>,
) -> Result<CommandOutcome, CommandError> {
    if let Some(path) = json {
        output_files::write_json(report, path)?;
    }
    report.command_outcome()
}
