//! The first and the last actions that several commands share.

use std::path::Path;

use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::instance::instance::Instance;

use crate::cli::arguments::RoleArguments;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::run_report::Report;
use crate::system::cores;
use crate::system::signals;

/// Attempts to enter an instance that another process creates or leaves at the same time.
const ENTER_ATTEMPTS_MAX: usize = 5;

/// Sets up the signals and the core of a process that a supervisor may have started.
pub(crate) fn prepare_process(role: &RoleArguments) {
    if role.report_lines {
        signals::end_with_parent();
    }
    signals::install();
    cores::pin(role.core);
}

/// Enters an instance. Creates it if it does not exist.
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

/// Writes the report to `json`, if given, and returns the outcome of the command.
pub(crate) fn write_report(
    report: &Report,
    json: Option<&Path>,
) -> Result<CommandOutcome, CommandError> {
    if let Some(path) = json {
        output_files::write_json(report, path)?;
    }
    report.command_outcome()
}
