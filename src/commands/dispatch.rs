//! Runs the command that the command line names.

use std::io::{ErrorKind, Write};

use crate::cli::arguments::{Arguments, Command, ConfigCommand};
use crate::commands::bench::command;
use crate::commands::{
    check, completions, config, control, doctor, explain, export, list, man, monitor, new, picture,
    plan, prepare, request, robot, sample, view, walk,
};
use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::report::reporter::Reporter;
use crate::system::terminal;

/// Reports that the stack is limited to this many KiB and no other can be made; returns the exit
/// code.
pub fn report_small_stack(kib: u64) -> u8 {
    let error = CommandError::Stack { kib };
    report_error(&error, false);
    error.code()
}

/// Runs a command and returns its exit code.
pub fn run(arguments: &Arguments) -> u8 {
    let result = match &arguments.command {
        Command::Walk(arguments) => walk::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Control(arguments) => control::run(arguments),
        Command::Request(arguments) => request::run(arguments),
        Command::Monitor(arguments) => monitor::run(arguments),
        Command::Sample(arguments) => sample::run(arguments),
        Command::Prepare(arguments) => prepare::run(arguments),
        Command::Robot(command) => robot::run(command),
        Command::Check(arguments) => check::run(arguments),
        Command::Config(ConfigCommand::Show(arguments)) => config::run(arguments),
        Command::Config(ConfigCommand::Iceoryx2(arguments)) => config::print_iceoryx(arguments),
        Command::Bench(arguments) => command::run(arguments),
        Command::Doctor(arguments) => doctor::run(arguments),
        Command::List(arguments) => list::run(arguments),
        Command::New(arguments) => new::run(arguments),
        Command::Picture(arguments) => picture::run(arguments),
        Command::Explain(arguments) => explain::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::View(arguments) => view::run(arguments),
        Command::Completions(arguments) => completions::run(arguments),
        Command::Man(arguments) => man::run(arguments),
    };
    // A signal that came at the very end is not forgotten; a process that serves ends by one.
    let ends_by_signal = match &arguments.command {
        Command::Control(control) => control.serve,
        Command::Plan(plan) => plan.serve,
        _ => false,
    };
    let result = match result {
        Ok(outcome) if !ends_by_signal => CommandError::unless_interrupted().map(|()| outcome),
        result => result,
    };
    match result {
        Ok(_) if terminal::has_lost_output() => result_not_printed(),
        Ok(outcome) => outcome.code(),
        Err(error) => {
            report_error(&error, arguments.reports_lines());
            error.code()
        }
    }
}

/// Prints help, the version, or an error of the command line; returns the exit code.
pub fn print_usage(text: &clap::Error) -> u8 {
    let printed = text.print().and_then(|()| std::io::stdout().flush());
    let is_lost = printed.is_err_and(|error| error.kind() != ErrorKind::BrokenPipe);
    match text.exit_code() {
        0 if is_lost => result_not_printed(),
        code => u8::try_from(code).unwrap_or(u8::MAX),
    }
}

fn result_not_printed() -> u8 {
    terminal::print_error(&CommandError::ResultNotPrinted);
    CommandError::ResultNotPrinted.code()
}

/// Reports the error that ended a command: to the supervisor, or on the terminal.
fn report_error(error: &CommandError, to_supervisor: bool) {
    match error {
        CommandError::Interrupted(_) | CommandError::ReportsClosed(_) if to_supervisor => {}
        _ if to_supervisor => {
            let emitted = Reporter::Supervisor.emit(&RoleEvent::Failed {
                is_transport: error.is_transport(),
                message: error.to_string(),
            });
            emitted.unwrap_or_else(|closed| terminal::print_error(&closed));
        }
        _ => terminal::print_error(error),
    }
}
