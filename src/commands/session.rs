//! The first and the last actions that several commands share.

use std::path::Path;

use crate::cli::arguments::RoleArguments;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::liveness;
use crate::report::run_report::Report;
use crate::system::cores;
use crate::system::signals;

/// Sets up the signals and the core of a process that a supervisor may have started.
pub(crate) fn prepare_process(role: &RoleArguments) {
    if role.report_lines {
        signals::end_with_parent();
        liveness::start();
    }
    signals::install();
    cores::pin(role.core);
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
