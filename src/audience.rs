//! Who hears what a role process tells.

use std::io::Write;

use crate::failure::Failure;
use crate::line::Line;
use crate::progress::Progress;

/// Who hears what a role process tells.
#[derive(Debug)]
pub enum Audience {
    /// A supervisor, by JSON lines on stdout.
    Supervisor,
    /// A person.
    Person(Progress),
}

impl Audience {
    /// A supervisor, or a person who may want quiet.
    pub fn new(report_lines: bool, quiet: bool) -> Self {
        if report_lines { Self::Supervisor } else { Self::Person(Progress::new(quiet)) }
    }

    /// Tells.
    ///
    /// # Errors
    /// When the supervisor is gone.
    pub fn tell(&mut self, line: &Line) -> Result<(), Failure> {
        match self {
            Self::Supervisor => write_line(line).map_err(Failure::Unheard),
            Self::Person(progress) => {
                progress.show(line);
                Ok(())
            }
        }
    }

    /// Says a result to a person; a supervisor has heard it already.
    pub fn say(&self, text: impl FnOnce() -> String) {
        if let Self::Person(_) = self {
            crate::terminal::say(&text());
        }
    }
}

fn write_line(line: &Line) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    serde_json::to_writer(&mut out, line)?;
    out.write_all(b"\n")?;
    out.flush()
}
