//! The running processes of the roles and the queue of their output.
//!
//! One thread per process reads its stdout and queues the lines.

use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::report::role::Role;
use crate::supervisor::process::{Process, ProcessOutput};
use crate::system::signals;

/// Time between two checks for a signal.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// An event of a process.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ProcessEvent {
    /// It reported an event.
    Reported(RoleEvent),
    /// It ended.
    Ended {
        /// Its role.
        role: Role,
        /// Its exit status.
        how: String,
    },
}

/// The running processes. Dropping the value ends them.
#[derive(Debug)]
pub(crate) struct RoleProcesses {
    processes: Vec<(Role, Process)>,
    sender: Sender<(Role, ProcessOutput)>,
    receiver: Receiver<(Role, ProcessOutput)>,
}

impl Default for RoleProcesses {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { processes: Vec::new(), sender, receiver }
    }
}

impl RoleProcesses {
    /// Starts a role's process.
    ///
    /// # Errors
    /// The system does not start it.
    pub(crate) fn start(&mut self, role: Role, command: Command) -> Result<(), CommandError> {
        let process = Process::start(command, role, self.sender.clone())
            .map_err(|source| CommandError::Start { role, source })?;
        self.processes.push((role, process));
        Ok(())
    }

    /// Waits for the next event.
    ///
    /// # Errors
    /// A signal asks this process to end, a role reports an error, or its output is not an event.
    pub(crate) fn next_event(&mut self) -> Result<ProcessEvent, CommandError> {
        loop {
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            if let Ok((role, output)) = self.receiver.recv_timeout(POLL_INTERVAL) {
                return self.event_of(role, output);
            }
        }
    }

    fn event_of(
        &mut self,
        role: Role,
        output: ProcessOutput,
    ) -> Result<ProcessEvent, CommandError> {
        match output {
            ProcessOutput::Event(RoleEvent::Failed { message }) => {
                Err(CommandError::Role { role, message })
            }
            ProcessOutput::Event(event) => Ok(ProcessEvent::Reported(event)),
            ProcessOutput::NonEvent(text) => {
                let message =
                    format!("printed '{text}', which is not an event; use one surefoot for both");
                Err(CommandError::Role { role, message })
            }
            ProcessOutput::Closed => Ok(ProcessEvent::Ended { role, how: self.reap(role) }),
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

impl Drop for RoleProcesses {
    fn drop(&mut self) {
        self.processes.iter().for_each(|(_, process)| process.ask_to_end());
        self.processes.drain(..).for_each(|(_, process)| drop(process.wait()));
    }
}
