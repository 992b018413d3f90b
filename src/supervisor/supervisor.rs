//! Starts the processes of both roles, reads their events, restarts a process that ends too early,
//! and ends both when they have reported their results.
//!
//! `Supervisor::step` runs one stage; `TRANSITIONS` holds the stage that follows.

use std::process::Command;

use crate::report::command_error::CommandError;
use crate::report::event::RoleEvent;
use crate::report::role::Role;
use crate::supervisor::role_processes::{ProcessEvent, RoleProcesses};
use crate::supervisor::walk_state::WalkState;
use crate::system::clock::Stopwatch;

/// Longest time from the planner's result to the controller's, s. The controller reports it as soon
/// as it has executed the last chunk; a killed one is started again within this time.
const CONFIRMATION_SECONDS_MAX: f64 = 30.0;

/// A stage of the supervision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Start both processes.
    Start,
    /// Read their next event.
    Read,
    /// Start the process again that ended too early.
    Restart,
    /// End the processes that still run.
    End,
    /// Nothing is left to do.
    Over,
}

/// The event that ends a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    Started,
    Reported,
    EndedEarly,
    Complete,
    Ended,
}

/// The transitions between the stages. An error of a stage ends the supervision.
const TRANSITIONS: [(Stage, Event, Stage); 6] = [
    (Stage::Start, Event::Started, Stage::Read),
    (Stage::Read, Event::Reported, Stage::Read),
    (Stage::Read, Event::EndedEarly, Stage::Restart),
    (Stage::Read, Event::Complete, Stage::End),
    (Stage::Restart, Event::Started, Stage::Read),
    (Stage::End, Event::Ended, Stage::Over),
];

/// The stage that follows `stage` after `event`.
fn next(stage: Stage, event: Event) -> Stage {
    let found = TRANSITIONS.iter().find(|row| (row.0, row.1) == (stage, event));
    found.map_or(Stage::End, |row| row.2)
}

/// Supervises the two processes of a walk.
pub struct Supervisor<'a> {
    /// The command line of a role's process.
    command_of: &'a dyn Fn(Role) -> Result<Command, CommandError>,
    /// Receives every event of the roles and every restart.
    on_event: &'a mut dyn FnMut(&RoleEvent),
    processes: RoleProcesses,
    state: WalkState,
    restarts_left: u32,
    /// The role whose process ended too early, and its exit status.
    ended: Option<(Role, String)>,
    /// The planner's result that the controller has not reported, and the time since then.
    unconfirmed: Option<(&'static str, Stopwatch)>,
}

impl<'a> Supervisor<'a> {
    /// A supervisor that starts processes again at most `restarts_max` times in all.
    pub fn new(
        command_of: &'a dyn Fn(Role) -> Result<Command, CommandError>,
        on_event: &'a mut dyn FnMut(&RoleEvent),
        restarts_max: u32,
    ) -> Self {
        Self {
            command_of,
            on_event,
            processes: RoleProcesses::default(),
            state: WalkState::default(),
            restarts_left: restarts_max,
            ended: None,
            unconfirmed: None,
        }
    }

    /// Runs both processes until they have reported their results.
    ///
    /// # Errors
    /// A process cannot be started, reports an error or ends too often, or a signal asks this
    /// process to end.
    pub fn run(mut self) -> Result<(), CommandError> {
        let mut stage = Stage::Start;
        while stage != Stage::Over {
            stage = match self.step(stage) {
                Ok(event) => next(stage, event),
                Err(error) => {
                    if matches!(error, CommandError::Interrupted(_)) {
                        self.processes.end(self.on_event);
                    }
                    return Err(error);
                }
            };
        }
        Ok(())
    }

    fn step(&mut self, stage: Stage) -> Result<Event, CommandError> {
        match stage {
            Stage::Start => self.start(),
            Stage::Read => self.read(),
            Stage::Restart => self.restart(),
            Stage::End | Stage::Over => Ok(self.end()),
        }
    }

    fn start(&mut self) -> Result<Event, CommandError> {
        for role in [Role::Controller, Role::Planner] {
            self.processes.start(role, (self.command_of)(role)?)?;
        }
        Ok(Event::Started)
    }

    fn read(&mut self) -> Result<Event, CommandError> {
        let unconfirmed = self.unconfirmed;
        let is_late =
            || unconfirmed.is_some_and(|(_, since)| since.seconds() > CONFIRMATION_SECONDS_MAX);
        let Some(event) = self.processes.next_event(&is_late)? else {
            let result = unconfirmed.map_or("", |(result, _)| result);
            return Err(CommandError::Disagreement { result, seconds: CONFIRMATION_SECONDS_MAX });
        };
        match event {
            ProcessEvent::Reported(event) => {
                self.state.record(&event);
                (self.on_event)(&event);
            }
            ProcessEvent::Ended { role, how } if self.state.needs(role) => {
                self.ended = Some((role, how));
                return Ok(Event::EndedEarly);
            }
            ProcessEvent::Ended { .. } => {}
        }
        self.watch_confirmation();
        Ok(if self.state.is_over() { Event::Complete } else { Event::Reported })
    }

    /// Begins to wait for the controller's result when the planner has reported one.
    fn watch_confirmation(&mut self) {
        self.unconfirmed = match (self.state.unconfirmed(), self.unconfirmed) {
            (Some(result), Some((before, since))) if result == before => Some((result, since)),
            (Some(result), _) => Some((result, Stopwatch::start())),
            (None, _) => None,
        };
    }

    fn restart(&mut self) -> Result<Event, CommandError> {
        let Some((role, how)) = self.ended.take() else { return Ok(Event::Started) };
        if self.restarts_left == 0 {
            return Err(CommandError::EndedEarly { role, how });
        }
        self.restarts_left -= 1;
        (self.on_event)(&RoleEvent::Restarted { role: role.to_string(), how });
        self.processes.start(role, (self.command_of)(role)?)?;
        Ok(Event::Started)
    }

    fn end(&mut self) -> Event {
        self.processes = RoleProcesses::default();
        Event::Ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_leads_to_the_end() {
        for stage in [Stage::Start, Stage::Read, Stage::Restart, Stage::End] {
            let mut reached = vec![stage];
            for _ in 0..TRANSITIONS.len() {
                let following =
                    TRANSITIONS.iter().filter(|row| reached.contains(&row.0)).map(|row| row.2);
                let following: Vec<Stage> = following.collect();
                reached.extend(following);
            }
            assert!(reached.contains(&Stage::Over), "{stage:?}");
        }
    }
}
