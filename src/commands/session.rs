//! The first and the last actions that several commands share.

use crate::cli::arguments::{OutputArguments, RoleArguments};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::liveness;
use crate::report::run_report::Report;
use crate::report::summary;
use crate::system::cores;
use crate::system::{signals, terminal};

/// Sets up the core of a process that a supervisor may have started, and its sign of life.
pub(crate) fn prepare_process(role: &RoleArguments) {
    if role.report_lines {
        signals::end_with_parent();
        liveness::start();
    }
    cores::pin(role.core);
}

/// How a command ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FinishArguments<'a> {
    /// The files that it writes.
    pub(crate) outputs: &'a OutputArguments,
    /// Whether a supervisor prints the summary.
    pub(crate) is_role: bool,
}

/// Ends a command: writes its report, prints its summary, draws its picture, and returns its
/// outcome. A signal and a file that cannot be written do not keep the results from being printed.
pub(crate) fn finish(
    report: &mut Report,
    arguments: FinishArguments<'_>,
    run: Result<(), CommandError>,
    draw: impl FnOnce() -> Result<(), CommandError>,
) -> Result<CommandOutcome, CommandError> {
    let FinishArguments { outputs, is_role } = arguments;
    let run = run.and_then(|()| CommandError::unless_interrupted());
    if let Err(error) = &run {
        report.record_error(error);
    }
    let has_begun = |error: &CommandError| error.name().is_some() || error.is_output();
    let is_reported = run.as_ref().err().is_none_or(has_begun);
    let json = outputs.json.as_deref().filter(|_| is_reported);
    let written = json.map_or(Ok(()), |path| output_files::write_json(report, path));
    let outcome = run.and_then(|()| report.command_outcome());
    let is_shown = match &outcome {
        Ok(_) | Err(CommandError::Interrupted(_)) => true,
        Err(error) => error.is_output(),
    };
    if is_shown && !is_role {
        let text = summary::text(report);
        match output_files::use_standard_output(outputs) {
            true => terminal::print_note(&text),
            false => terminal::print_result(&text),
        }
    }
    let drawn = match &outcome {
        Ok(_) | Err(CommandError::Endpoint(_)) => draw(),
        Err(_) => Ok(()),
    };
    let outcome = outcome?;
    written.and(drawn).map(|()| outcome)
}
