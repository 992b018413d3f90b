//! The running processes of the roles and the queue of their output.
//!
//! One thread per process reads its stdout and queues the lines.

use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::report::role::Role;
use crate::supervisor::process::{GRACE_SECONDS, Process, ProcessOutput};
use crate::supervisor::silence::Silence;
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Time between two checks for a signal and for silent processes.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// An event of a process.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ProcessEvent {
    /// It reported an event.
    Reported(Box<RoleEvent>),
    /// It ended.
    Ended {
        /// Its role.
        role: Role,
        /// Its exit status.
        how: String,
    },
}

/// A running process and its last signs.
#[derive(Debug)]
struct RoleProcess {
    role: Role,
    process: Process,
    silence: Silence,
    /// The reason why it ends or is killed, if it is known before its end.
    failure: Option<String>,
}

/// The running processes. Dropping the value ends them.
#[derive(Debug)]
pub(crate) struct RoleProcesses {
    processes: Vec<RoleProcess>,
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
        let silence = Silence::of_start(process.id());
        self.processes.push(RoleProcess { role, process, silence, failure: None });
        Ok(())
    }

    /// Waits for the next event, at most until `is_late` returns true; `None` then. Kills a process
    /// that emits none for too long.
    ///
    /// # Errors
    /// A signal asks this process to end, a role reports an error other than of the transport, or
    /// its output is not an event.
    pub(crate) fn next_event(
        &mut self,
        is_late: &dyn Fn() -> bool,
    ) -> Result<Option<ProcessEvent>, CommandError> {
        loop {
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            if let Ok((role, output)) = self.receiver.recv_timeout(POLL_INTERVAL)
                && let Some(event) = self.event_of(role, output)?
            {
                return Ok(Some(event));
            }
            self.kill_silent();
            if is_late() {
                return Ok(None);
            }
        }
    }

    /// Asks all processes to end, and passes on what they report until they have.
    pub(crate) fn end(&mut self, on_event: &mut dyn FnMut(&RoleEvent)) {
        self.processes.iter().for_each(|process| process.process.ask_to_end());
        let watch = Stopwatch::start();
        let mut running = self.processes.len();
        while running > 0 && watch.seconds() < GRACE_SECONDS {
            match self.receiver.recv_timeout(POLL_INTERVAL) {
                Ok((_, ProcessOutput::Event(event))) => {
                    if !matches!(*event, RoleEvent::Alive | RoleEvent::Failed { .. }) {
                        on_event(&event);
                    }
                }
                Ok((_, ProcessOutput::Closed)) => running -= 1,
                Ok((_, ProcessOutput::NonEvent(_))) | Err(_) => {}
            }
        }
    }

    fn kill_silent(&mut self) {
        for process in &mut self.processes {
            if process.failure.is_none()
                && let Some(seconds_max) = process.silence.exceeded()
            {
                process.failure = Some(format!("no event for {seconds_max} s"));
                process.process.kill();
            }
        }
    }

    fn process_of(&mut self, role: Role) -> Option<&mut RoleProcess> {
        self.processes.iter_mut().find(|process| process.role == role)
    }

    fn event_of(
        &mut self,
        role: Role,
        output: ProcessOutput,
    ) -> Result<Option<ProcessEvent>, CommandError> {
        if let Some(process) = self.process_of(role) {
            process.silence.end();
        }
        match output {
            ProcessOutput::Event(event) => match *event {
                RoleEvent::Alive => Ok(None),
                RoleEvent::Failed { is_transport: true, message } => {
                    // The process ends by itself; its end is the event.
                    if let Some(process) = self.process_of(role) {
                        process.failure = Some(message);
                    }
                    Ok(None)
                }
                RoleEvent::Failed { message, .. } => Err(CommandError::Role { role, message }),
                _ => Ok(Some(ProcessEvent::Reported(event))),
            },
            ProcessOutput::NonEvent(text) => {
                let message =
                    format!("printed '{text}', which is not an event; use one surefoot for both");
                Err(CommandError::Role { role, message })
            }
            ProcessOutput::Closed => Ok(Some(ProcessEvent::Ended { role, how: self.reap(role) })),
        }
    }

    /// Waits for the end of a process that closed its stdout. Returns its failure, or else its exit
    /// status.
    fn reap(&mut self, role: Role) -> String {
        let Some(index) = self.processes.iter().position(|process| process.role == role) else {
            return "it was not running".to_owned();
        };
        let RoleProcess { process, failure, .. } = self.processes.swap_remove(index);
        let status = process.wait();
        failure.unwrap_or(status)
    }
}

impl Drop for RoleProcesses {
    fn drop(&mut self) {
        self.processes.iter().for_each(|process| process.process.ask_to_end());
        self.processes.drain(..).for_each(|process| drop(process.process.wait()));
    }
}
