//! The report of a run, collected from its events.

use serde::Serialize;

use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{
    CheckSummary, Delivered, DeliveryResult, Diagnosis, Improved, PlanResult, Planned, Refusal,
    RoleEvent, SmoothMotion,
};
use crate::report::margins::WorstMargins;
use crate::report::walk_facts::WalkFacts;

/// The report of a run, written by `--json`. Values that a run did not reach are null or 0.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Report {
    /// The planner's outcome, or once a plan was delivered `accepted`, `refused`, `stopped`,
    /// `controller_lost`, `contradicted`; `planner_failed` or `controller_failed` when a process
    /// ended before its work was done, and `interrupted` when a signal came.
    pub outcome: String,
    /// The result of the search, as one line of text: what ended it, where, and what to do.
    pub description: Option<String>,
    /// The parameter of the budget that ended the search.
    pub bound: Option<String>,
    /// The scenario's name.
    pub scenario: String,
    /// The robot's name.
    pub robot: String,
    /// The world's name.
    pub world: String,
    /// The seed.
    pub seed: u64,
    /// Planner threads.
    pub threads: usize,
    /// Digest of the chunk stream.
    pub digest: Option<String>,
    /// Time until the planner had all its memory, s.
    pub ready_seconds: Option<f64>,
    /// Time of the search, s.
    pub plan_seconds: Option<f64>,
    /// Time of the search until the first chunk was sent, s; without a delivery, until it was
    /// final.
    pub first_chunk_seconds: Option<f64>,
    /// Time that the controller spent checking, s.
    pub check_seconds: Option<f64>,
    /// Work units used.
    pub work: u64,
    /// Sequences tried.
    pub sequences: u64,
    /// The diagnosis of a search that a bound ended.
    pub diagnosis: Option<Box<Diagnosis>>,
    /// Edges of the guide route.
    pub route_edges: u64,
    /// Edges of the guide route that are possible, so that primitives lead along.
    pub route_edges_possible: u64,
    /// Motions that were primitives, in the plan or not.
    pub primitives: u64,
    /// Steps of the plan.
    pub steps: u64,
    /// Waypoints of the plan.
    pub waypoints: u64,
    /// The plan as a walk; of a replanned walk, its last plan.
    pub walk: Option<WalkFacts>,
    /// Counts of a smooth motion; none of a quasi-static one.
    pub smooth: Option<Box<SmoothMotion>>,
    /// What the improvement of the plan came to (`--improve`).
    pub improved: Option<Improved>,
    /// Size of the planner's arenas.
    pub arena_bytes: u64,
    /// Heap allocations of the planner process during the search.
    pub allocations_after_ready: u64,
    /// Counts of the chunks.
    pub chunks: Chunks,
    /// Chunks that the controller held back (`--late`).
    pub late_chunks: u64,
    /// How often the robot had to stop because the next chunk was not there.
    pub brakes: u64,
    /// How long it stood for that reason, s of its own time.
    pub stood_seconds: f64,
    /// The worst margin of each check.
    pub margins: WorstMargins,
    /// The refusal, if there was one.
    pub refusal: Option<Refusal>,
    /// Number of replans.
    pub replans: u64,
    /// Number of restarts of killed processes.
    pub restarts: u64,
    #[serde(skip)]
    result: Option<PlanResult>,
    #[serde(skip)]
    delivery_result: Option<DeliveryResult>,
}

/// The names of a run's inputs, and its seed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RunNames {
    /// The scenario's name.
    pub scenario: String,
    /// The robot's name.
    pub robot: String,
    /// The world's name.
    pub world: String,
    /// The seed of the search.
    pub seed: u64,
}

/// Counts of a plan's chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Chunks {
    /// Chunks sent, each counted once.
    pub sent: u64,
    /// Chunks accepted.
    pub accepted: u64,
    /// Chunks refused; those behind a refused one are not checked.
    pub refused: u64,
    /// Chunks sent and, without any refusal, never accepted.
    pub lost: u64,
    /// Chunks on their way, and not answered yet, when a signal ended the delivery.
    pub in_flight: u64,
    /// Chunks that the controller received again after it had accepted them, and did not walk
    /// again.
    pub duplicated: u64,
    /// Chunks with a wrong CRC that the controller dropped; none of the planner's is among them
    /// unless it was sent again.
    pub damaged: u64,
    /// Chunks of publishers other than the planner's, which the controller dropped: forged, or left
    /// over from a planner that was killed, which were sent again.
    pub other_senders: u64,
    /// Number of times that a chunk was sent again.
    pub resent: u64,
    /// Feedback messages of publishers other than the controller's, which the planner dropped:
    /// forged, or left over from a controller that was killed.
    pub feedback_dropped: u64,
}

impl Report {
    /// The report of a run that has not begun.
    pub fn new(names: RunNames, threads: usize) -> Self {
        let RunNames { scenario, robot, world, seed } = names;
        Self { scenario, robot, world, seed, threads, ..Self::default() }
    }

    /// Records an event of a role.
    pub fn record(&mut self, event: &RoleEvent) {
        match event {
            RoleEvent::PlannerReady { ready_seconds, arena_bytes } => {
                self.ready_seconds = Some(*ready_seconds);
                self.arena_bytes = *arena_bytes;
            }
            RoleEvent::Planned(planned) => self.record_planned(planned),
            RoleEvent::Delivered(delivered) => self.record_delivered(delivered),
            RoleEvent::Checked(checked) => self.record_checked(checked),
            RoleEvent::Restarted { .. } => self.restarts += 1,
            RoleEvent::Replanning { .. } => self.replans += 1,
            RoleEvent::Alive
            | RoleEvent::PlannerServes
            | RoleEvent::Retracing
            | RoleEvent::Improving { .. }
            | RoleEvent::Holding { .. }
            | RoleEvent::Planning(_)
            | RoleEvent::Delivering { .. }
            | RoleEvent::ControllerReady
            | RoleEvent::Failed { .. } => {}
        }
    }

    /// Records the error that ended the run.
    pub fn record_error(&mut self, error: &CommandError) {
        if let Some(name) = error.name() {
            self.outcome = name.to_owned();
        }
    }

    /// Whether a plan was found.
    pub fn has_plan(&self) -> bool {
        self.result == Some(PlanResult::Found)
    }

    /// The result of the search, as one line of text.
    pub fn description(&self) -> &str {
        self.description.as_deref().unwrap_or("ended before a search had a result")
    }

    /// The result of the delivery, if there was one.
    pub fn delivery_result(&self) -> Option<DeliveryResult> {
        self.delivery_result
    }

    /// The outcome of the command.
    ///
    /// # Errors
    /// The start or the goal is invalid, no controller answers, or a signal came.
    pub fn command_outcome(&self) -> Result<CommandOutcome, CommandError> {
        match (self.result, self.delivery_result) {
            (Some(PlanResult::NoPlan), _) => Ok(CommandOutcome::NoPlan),
            (Some(PlanResult::Found), None | Some(DeliveryResult::Accepted)) => {
                Ok(CommandOutcome::Done)
            }
            (Some(PlanResult::Found), Some(DeliveryResult::Refused)) => Ok(CommandOutcome::Refused),
            (
                Some(PlanResult::Found),
                Some(DeliveryResult::Superseded | DeliveryResult::ControllerLost),
            ) => Err(CommandError::ControllerLost),
            (Some(PlanResult::Found), Some(DeliveryResult::Contradicted)) => {
                Err(CommandError::Contradicted)
            }
            (Some(PlanResult::StartInvalid | PlanResult::GoalInvalid), _) => {
                Err(CommandError::Endpoint(self.description().to_owned()))
            }
            _ => Err(CommandError::interrupted()),
        }
    }

    fn record_planned(&mut self, planned: &Planned) {
        self.result = Some(planned.result);
        self.outcome = planned.outcome.clone();
        self.description = Some(planned.description.clone());
        self.bound = planned.bound.clone();
        self.digest = planned.digest.clone();
        self.plan_seconds = Some(planned.plan_seconds);
        self.first_chunk_seconds = planned.first_chunk_seconds;
        self.work = planned.work;
        self.sequences = planned.sequences;
        self.diagnosis = planned.diagnosis.clone();
        self.route_edges = planned.route_edges;
        self.route_edges_possible = planned.route_edges_possible;
        self.primitives = planned.primitives;
        self.steps = planned.steps;
        self.waypoints = planned.waypoints;
        self.walk = planned.walk;
        self.smooth = planned.smooth.clone();
        self.improved = planned.improved;
        self.allocations_after_ready = planned.allocations;
    }

    fn record_delivered(&mut self, delivered: &Delivered) {
        // A restarted planner sent fewer chunks than were accepted; its predecessor sent the rest.
        let sent = (delivered.sent - delivered.resent.min(delivered.sent)).max(delivered.accepted);
        let refused = delivered.result == DeliveryResult::Refused;
        let unanswered = sent.saturating_sub(delivered.accepted + delivered.withdrawn);
        let is_stopped = delivered.result == DeliveryResult::Stopped;
        self.delivery_result = Some(delivered.result);
        self.first_chunk_seconds = delivered.first_chunk_seconds;
        self.outcome = match delivered.result {
            DeliveryResult::Accepted => "accepted",
            DeliveryResult::Incomplete => "incomplete",
            DeliveryResult::Refused => "refused",
            DeliveryResult::Superseded => "superseded",
            DeliveryResult::ControllerLost => "controller_lost",
            DeliveryResult::Contradicted => "contradicted",
            DeliveryResult::Stopped => "stopped",
        }
        .to_owned();
        self.chunks = Chunks {
            sent,
            accepted: delivered.accepted,
            refused: u64::from(refused),
            lost: if refused || is_stopped { 0 } else { unanswered },
            in_flight: if is_stopped { unanswered } else { 0 },
            duplicated: delivered.duplicated.max(self.chunks.duplicated),
            damaged: self.chunks.damaged,
            other_senders: self.chunks.other_senders,
            resent: delivered.resent,
            feedback_dropped: delivered.feedback_dropped,
        };
        if self.check_seconds.is_none() {
            self.margins = delivered.margins;
            self.refusal = delivered.refusal.clone();
        }
    }

    /// The controller's own event takes precedence over the planner's account of it.
    fn record_checked(&mut self, checked: &CheckSummary) {
        self.check_seconds = Some(checked.check_seconds);
        self.chunks.duplicated = checked.duplicated.max(self.chunks.duplicated);
        self.chunks.damaged = checked.damaged.max(self.chunks.damaged);
        self.chunks.other_senders = checked.other_senders.max(self.chunks.other_senders);
        (self.late_chunks, self.brakes) = (checked.late_chunks, checked.brakes);
        self.stood_seconds = checked.stood_seconds;
        self.margins = checked.margins;
        self.refusal = checked.refusal.clone();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(detail: &str) -> Refusal {
        Refusal { check: "torque".into(), sequence: 3, waypoint: 1, detail: detail.into() }
    }

    fn planned(end: PlanResult) -> RoleEvent {
        RoleEvent::Planned(Planned {
            result: end,
            outcome: "found".into(),
            bound: None,
            description: String::new(),
            digest: None,
            plan_seconds: 1.0,
            first_chunk_seconds: Some(0.5),
            work: 2,
            sequences: 1,
            diagnosis: None,
            route_edges: 8,
            route_edges_possible: 6,
            primitives: 20,
            allocations: 0,
            steps: 3,
            waypoints: 4,
            chunks: 9,
            walk: None,
            smooth: None,
            improved: None,
        })
    }

    fn delivered(end: DeliveryResult, accepted: u64) -> RoleEvent {
        let refusal = (end == DeliveryResult::Refused).then(|| refusal(""));
        RoleEvent::Delivered(Delivered {
            result: end,
            sent: 9,
            resent: 2,
            accepted,
            withdrawn: 0,
            feedback_dropped: 5,
            duplicated: 1,
            margins: WorstMargins::default(),
            refusal,
            first_chunk_seconds: Some(0.25),
        })
    }

    fn checked() -> RoleEvent {
        let margins = WorstMargins { torque: Some(0.25), ..WorstMargins::default() };
        RoleEvent::Checked(CheckSummary {
            check_seconds: 0.5,
            accepted: 3,
            duplicated: 2,
            damaged: 5,
            other_senders: 6,
            late_chunks: 4,
            brakes: 2,
            stood_seconds: 3.12,
            margins,
            refusal: Some(refusal("left_knee 120 %")),
        })
    }

    #[test]
    fn a_refusal_keeps_the_controllers_detail_in_whatever_order_the_lines_come() {
        for lines in [
            [delivered(DeliveryResult::Refused, 3), checked()],
            [checked(), delivered(DeliveryResult::Refused, 3)],
        ] {
            let mut report = Report::default();
            report.record(&planned(PlanResult::Found));
            lines.iter().for_each(|event| report.record(event));
            assert_eq!(report.refusal.as_ref().unwrap().detail, "left_knee 120 %");
            let no_chunks = Chunks::default();
            assert_eq!(
                report.chunks,
                Chunks {
                    sent: 7,
                    accepted: 3,
                    refused: 1,
                    duplicated: 2,
                    damaged: 5,
                    other_senders: 6,
                    resent: 2,
                    feedback_dropped: 5,
                    ..no_chunks
                }
            );
            assert_eq!(report.margins.torque, Some(0.25));
            let text = crate::report::summary::text(&report);
            let stops = "\n  stops      4 chunks held back, braked 2 times, stood 3.1 s\n";
            assert!(text.contains(stops), "{text}");
            let dropped = ", 5 feedback messages of other senders dropped";
            assert!(text.contains(dropped), "{text}");
            assert_eq!(report.command_outcome().unwrap(), CommandOutcome::Refused);
        }
    }

    #[test]
    fn every_end_has_its_exit_code() {
        let cases = [
            (PlanResult::Found, None, 0),
            (PlanResult::Found, Some(DeliveryResult::Accepted), 0),
            (PlanResult::Found, Some(DeliveryResult::Refused), 4),
            (PlanResult::Found, Some(DeliveryResult::ControllerLost), 2),
            (PlanResult::Found, Some(DeliveryResult::Contradicted), 2),
            (PlanResult::NoPlan, None, 3),
            (PlanResult::StartInvalid, None, 2),
            (PlanResult::GoalInvalid, None, 2),
        ];
        for (end, delivery, code) in cases {
            let mut report = Report::default();
            report.record(&planned(end));
            delivery.iter().for_each(|delivery| report.record(&delivered(*delivery, 7)));
            assert_eq!(
                report.command_outcome().map_or_else(|error| error.code(), CommandOutcome::code),
                code,
                "{end:?} {delivery:?}"
            );
        }
    }

    #[test]
    fn chunks_that_were_not_accepted_are_lost() {
        let mut report = Report::default();
        report.record(&delivered(DeliveryResult::ControllerLost, 5));
        assert_eq!(
            (report.chunks.sent, report.chunks.lost, report.outcome.as_str()),
            (7, 2, "controller_lost")
        );
    }

    #[test]
    fn chunks_on_their_way_are_not_lost_when_a_signal_comes() {
        let mut report = Report::default();
        report.record(&delivered(DeliveryResult::Stopped, 5));
        let Chunks { sent, lost, in_flight, .. } = report.chunks;
        assert_eq!((sent, lost, in_flight), (7, 0, 2));
    }

    #[test]
    fn chunks_of_a_replaced_plan_are_not_lost() {
        let RoleEvent::Delivered(replanned) = delivered(DeliveryResult::Accepted, 5) else {
            panic!("another event")
        };
        let mut report = Report::default();
        report.record(&RoleEvent::Delivered(Delivered { withdrawn: 2, ..replanned }));
        assert_eq!((report.chunks.sent, report.chunks.accepted, report.chunks.lost), (7, 5, 0));
    }
}
