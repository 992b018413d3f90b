//! Starts the role processes, hears what they tell, notices when they end, and ends them.
//!
//! Each process's lines are read by a thread of its own and queued; [`Supervisor::next_event`] is
//! the only place where anything is decided. A role that ended can be started again: nothing of the
//! process before it remains.

mod process;

use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::failure::Failure;
use crate::line::Line;
use crate::signals;

use process::{News, Process};

/// Time between two looks at the signals.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What a process does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Plans and delivers.
    Planner,
    /// Checks and walks.
    Controller,
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planner => "planner",
            Self::Controller => "controller",
        })
    }
}

/// Something that happened to a role.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// It told something.
    Told(Line),
    /// Its process is over.
    Ended {
        /// Whose.
        role: Role,
        /// Its exit status.
        how: String,
    },
}

/// Runs the role processes. Dropped, it ends those that still run.
#[derive(Debug)]
pub struct Supervisor {
    processes: Vec<(Role, Process)>,
    mouth: Sender<(Role, News)>,
    ear: Receiver<(Role, News)>,
}

impl Default for Supervisor {
    fn default() -> Self {
        let (mouth, ear) = channel();
        Self { processes: Vec::new(), mouth, ear }
    }
}

impl Supervisor {
    /// Starts a role's process.
    ///
    /// # Errors
    /// When the system does not start it.
    pub fn start(&mut self, role: Role, command: Command) -> Result<(), Failure> {
        let process = Process::start(command, role, self.mouth.clone())
            .map_err(|source| Failure::Start { role, source })?;
        self.processes.push((role, process));
        Ok(())
    }

    /// Waits for the next event.
    ///
    /// # Errors
    /// When a signal asks this process to end, or a role says that it cannot go on.
    pub fn next_event(&mut self) -> Result<Event, Failure> {
        loop {
            if let Some(signal) = signals::raised() {
                return Err(Failure::Interrupted(signal));
            }
            match self.ear.recv_timeout(LOOK_EVERY) {
                Ok((role, News::Told(Line::Failed { message }))) => {
                    return Err(Failure::Role { role, message });
                }
                Ok((_, News::Told(line))) => return Ok(Event::Told(line)),
                Ok((role, News::Babble(text))) => {
                    return Err(Failure::Role {
                        role,
                        message: format!(
                            "said '{text}', which is no report; use the same surefoot for both"
                        ),
                    });
                }
                Ok((role, News::Closed)) => return Ok(Event::Ended { role, how: self.bury(role) }),
                Err(_) => {}
            }
        }
    }

    /// Waits for the end of a process that closed its stdout, and says how it ended.
    fn bury(&mut self, role: Role) -> String {
        match self.processes.iter().position(|(other, _)| *other == role) {
            Some(index) => self.processes.swap_remove(index).1.wait(),
            None => "it was not running".to_owned(),
        }
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.processes.iter().for_each(|(_, process)| process.ask_to_end());
        self.processes.drain(..).for_each(|(_, process)| drop(process.wait()));
    }
}
