//! Starts the role processes, receives their events, notices when they end, and ends them.
//!
//! Each process's lines are read by a thread of its own and queued; [`Supervisor::next_event`] is
//! the only place where anything is decided. A role that ended can be started again: nothing of the
//! process before it remains.

use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::system::signals;

use crate::supervisor::process::{Process, ProcessOutput};

/// Time between two looks at the signals.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

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
pub enum SupervisorEvent {
    /// It reported an event.
    Reported(RoleEvent),
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
    sender: Sender<(Role, ProcessOutput)>,
    receiver: Receiver<(Role, ProcessOutput)>,
}

impl Default for Supervisor {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { processes: Vec::new(), sender, receiver }
    }
}

impl Supervisor {
    /// Starts a role's process.
    ///
    /// # Errors
    /// When the system does not start it.
    pub fn start(&mut self, role: Role, command: Command) -> Result<(), CommandError> {
        let process = Process::start(command, role, self.sender.clone())
            .map_err(|source| CommandError::Start { role, source })?;
        self.processes.push((role, process));
        Ok(())
    }

    /// Waits for the next event.
    ///
    /// # Errors
    /// When a signal asks this process to end, or a role reports that it cannot go on.
    pub fn next_event(&mut self) -> Result<SupervisorEvent, CommandError> {
        loop {
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            match self.receiver.recv_timeout(POLL_INTERVAL) {
                Ok((role, ProcessOutput::Event(RoleEvent::Failed { message }))) => {
                    return Err(CommandError::Role { role, message });
                }
                Ok((_, ProcessOutput::Event(event))) => {
                    return Ok(SupervisorEvent::Reported(event));
                }
                Ok((role, ProcessOutput::NonEvent(text))) => {
                    return Err(CommandError::Role {
                        role,
                        message: format!(
                            "said '{text}', which is no report; use the same surefoot for both"
                        ),
                    });
                }
                Ok((role, ProcessOutput::Closed)) => {
                    return Ok(SupervisorEvent::Ended { role, how: self.reap(role) });
                }
                Err(_) => {}
            }
        }
    }

    /// Waits for the end of a process that closed its stdout, and returns its exit status.
    fn reap(&mut self, role: Role) -> String {
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
