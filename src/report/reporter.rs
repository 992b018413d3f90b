//! The reporter of a role process.

use std::io::Write;

use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::report::progress::Progress;

/// Where a role process reports its events.
#[derive(Debug)]
pub enum Reporter {
    /// A supervisor, by JSON lines on stdout.
    Supervisor,
    /// The terminal.
    Person(Progress),
}

impl Reporter {
    /// The supervisor if `report_lines`, else the terminal, silent if `quiet`.
    pub fn new(report_lines: bool, quiet: bool) -> Self {
        if report_lines { Self::Supervisor } else { Self::Person(Progress::new(quiet)) }
    }

    /// Reports an event.
    ///
    /// # Errors
    /// When the supervisor is gone.
    pub fn emit(&mut self, event: &RoleEvent) -> Result<(), CommandError> {
        match self {
            Self::Supervisor => write_event(event).map_err(CommandError::ReportsClosed),
            Self::Person(progress) => {
                progress.show(event);
                Ok(())
            }
        }
    }

    /// Prints a result on the terminal; a supervisor has received the event already.
    pub fn print(&self, text: impl FnOnce() -> String) {
        if let Self::Person(_) = self {
            crate::system::terminal::print_result(&text());
        }
    }
}

fn write_event(event: &RoleEvent) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    serde_json::to_writer(&mut out, event)?;
    out.write_all(b"\n")?;
    out.flush()
}
