//! What became of a run, collected line by line.

use serde::Serialize;

use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Delivered, DeliveryEnd, Diagnosis, Judged, Line, PlanEnd, Planned, Refusal};
use crate::margins::WorstMargins;
use crate::signals;

/// The report of a run; `--json` writes it. What a run did not come to is null or 0.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Report {
    /// The planner's outcome, or once a plan was delivered `accepted`, `refused`, `stopped`,
    /// `controller_lost`; `planner_failed` or `controller_failed` when a process ended before its
    /// work was done.
    pub outcome: String,
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
    /// Time that the controller spent checking, s.
    pub check_seconds: Option<f64>,
    /// Work units used.
    pub work: u64,
    /// Sequences tried.
    pub sequences: u64,
    /// What is known of why there is no plan, where a bound ended the search.
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
    /// Size of the planner's arenas.
    pub arena_bytes: u64,
    /// Heap allocations of the planner process during the search.
    pub allocations_after_ready: u64,
    /// What became of the chunks.
    pub chunks: Chunks,
    /// The worst margin of each check.
    pub margins: WorstMargins,
    /// What was refused.
    pub refusal: Option<Refusal>,
    /// How often the rest of the way was planned again.
    pub replans: u64,
    /// How often a killed process was started again.
    pub restarts: u64,
    #[serde(skip)]
    end: Option<PlanEnd>,
    #[serde(skip)]
    delivery: Option<DeliveryEnd>,
    #[serde(skip)]
    description: String,
}

/// What became of a plan's chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Chunks {
    /// Chunks sent, each counted once.
    pub sent: u64,
    /// Chunks accepted.
    pub accepted: u64,
    /// Chunks refused; those behind a refused one are not judged.
    pub refused: u64,
    /// Chunks sent and, without any refusal, never accepted.
    pub lost: u64,
    /// Chunks that the controller received again after it had accepted them, and did not walk
    /// again.
    pub duplicated: u64,
    /// How often a chunk was sent again.
    pub resent: u64,
}

impl Report {
    /// The report of a run that has not begun.
    pub fn new(inputs: &Inputs, threads: usize) -> Self {
        let scenario = &inputs.scenario;
        Self {
            scenario: scenario.name.clone(),
            robot: inputs.model.name.clone(),
            world: scenario
                .world_path
                .file_stem()
                .map(|stem| stem.to_string_lossy().into_owned())
                .unwrap_or_default(),
            seed: scenario.seed,
            threads,
            ..Self::default()
        }
    }

    /// Takes in what a role told.
    pub fn note(&mut self, line: &Line) {
        match line {
            Line::PlannerReady { ready_seconds, arena_bytes } => {
                self.ready_seconds = Some(*ready_seconds);
                self.arena_bytes = *arena_bytes;
            }
            Line::Planned(planned) => self.note_planned(planned),
            Line::Delivered(delivered) => self.note_delivered(delivered),
            Line::Judged(judged) => self.note_judged(judged),
            Line::Restarted { .. } => self.restarts += 1,
            Line::Replanning { .. } => self.replans += 1,
            Line::PlannerServes
            | Line::WalkingBack
            | Line::Holding { .. }
            | Line::Planning(_)
            | Line::Delivering { .. }
            | Line::ControllerReady
            | Line::Failed { .. } => {}
        }
    }

    /// Takes in that the run broke off.
    pub fn note_failure(&mut self, failure: &Failure) {
        if let Some(word) = failure.word() {
            self.outcome = word.to_owned();
        }
    }

    /// Whether a plan was found.
    pub fn has_plan(&self) -> bool {
        self.end == Some(PlanEnd::Found)
    }

    /// How the search ended, in one line for a person.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// How the delivery ended, if there was one.
    pub fn delivery(&self) -> Option<DeliveryEnd> {
        self.delivery
    }

    /// How the command ends.
    ///
    /// # Errors
    /// When that is no answer: the robot cannot stand at an end, no controller answers, or a signal
    /// came.
    pub fn ending(&self) -> Result<Ending, Failure> {
        match (self.end, self.delivery) {
            (Some(PlanEnd::NoPlan), _) => Ok(Ending::NoPlan),
            (Some(PlanEnd::Found), None | Some(DeliveryEnd::Accepted)) => Ok(Ending::Done),
            (Some(PlanEnd::Found), Some(DeliveryEnd::Refused)) => Ok(Ending::Refused),
            (Some(PlanEnd::Found), Some(DeliveryEnd::Superseded | DeliveryEnd::ControllerLost)) => {
                Err(Failure::ControllerLost)
            }
            (Some(PlanEnd::StartInvalid | PlanEnd::GoalInvalid), _) => {
                Err(Failure::Ends(self.description.clone()))
            }
            _ => Err(Failure::Interrupted(signals::raised().unwrap_or(libc::SIGTERM))),
        }
    }

    fn note_planned(&mut self, planned: &Planned) {
        self.end = Some(planned.end);
        self.outcome = planned.outcome.clone();
        self.description = planned.description.clone();
        self.bound = planned.bound.clone();
        self.digest = planned.digest.clone();
        self.plan_seconds = Some(planned.plan_seconds);
        self.work = planned.work;
        self.sequences = planned.sequences;
        self.diagnosis = planned.diagnosis.clone();
        self.route_edges = planned.route_edges;
        self.route_edges_possible = planned.route_edges_possible;
        self.primitives = planned.primitives;
        self.steps = planned.steps;
        self.waypoints = planned.waypoints;
        self.allocations_after_ready = planned.allocations;
    }

    fn note_delivered(&mut self, delivered: &Delivered) {
        // A planner that was started again sent less than what was accepted: its predecessor sent
        // the rest.
        let sent = (delivered.sent - delivered.resent.min(delivered.sent)).max(delivered.accepted);
        let refused = delivered.end == DeliveryEnd::Refused;
        self.delivery = Some(delivered.end);
        self.outcome = match delivered.end {
            DeliveryEnd::Accepted => "accepted",
            DeliveryEnd::Refused => "refused",
            DeliveryEnd::Superseded => "superseded",
            DeliveryEnd::ControllerLost => "controller_lost",
            DeliveryEnd::Stopped => "stopped",
        }
        .to_owned();
        self.chunks = Chunks {
            sent,
            accepted: delivered.accepted,
            refused: u64::from(refused),
            lost: if refused {
                0
            } else {
                sent.saturating_sub(delivered.accepted + delivered.withdrawn)
            },
            duplicated: delivered.duplicated.max(self.chunks.duplicated),
            resent: delivered.resent,
        };
        if self.check_seconds.is_none() {
            self.margins = delivered.margins;
            self.refusal = delivered.refusal.clone();
        }
    }

    /// The controller's own words count more than what the planner heard of them.
    fn note_judged(&mut self, judged: &Judged) {
        self.check_seconds = Some(judged.check_seconds);
        self.chunks.duplicated = judged.duplicated.max(self.chunks.duplicated);
        self.margins = judged.margins;
        self.refusal = judged.refusal.clone();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(detail: &str) -> Refusal {
        Refusal { check: "torque".into(), sequence: 3, waypoint: 1, detail: detail.into() }
    }

    fn planned(end: PlanEnd) -> Line {
        Line::Planned(Planned {
            end,
            outcome: "found".into(),
            bound: None,
            description: String::new(),
            digest: None,
            plan_seconds: 1.0,
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
        })
    }

    fn delivered(end: DeliveryEnd, accepted: u64) -> Line {
        let refusal = (end == DeliveryEnd::Refused).then(|| refusal(""));
        Line::Delivered(Delivered {
            end,
            sent: 9,
            resent: 2,
            accepted,
            withdrawn: 0,
            duplicated: 1,
            margins: WorstMargins::default(),
            refusal,
        })
    }

    fn judged() -> Line {
        let margins = WorstMargins { torque: Some(0.25), ..WorstMargins::default() };
        Line::Judged(Judged {
            check_seconds: 0.5,
            accepted: 3,
            duplicated: 2,
            margins,
            refusal: Some(refusal("left_knee 120 %")),
        })
    }

    #[test]
    fn a_refusal_keeps_the_controllers_detail_in_whatever_order_the_lines_come() {
        for lines in [
            [delivered(DeliveryEnd::Refused, 3), judged()],
            [judged(), delivered(DeliveryEnd::Refused, 3)],
        ] {
            let mut report = Report::default();
            report.note(&planned(PlanEnd::Found));
            lines.iter().for_each(|line| report.note(line));
            assert_eq!(report.refusal.as_ref().unwrap().detail, "left_knee 120 %");
            assert_eq!(
                report.chunks,
                Chunks { sent: 7, accepted: 3, refused: 1, lost: 0, duplicated: 2, resent: 2 }
            );
            assert_eq!(report.margins.torque, Some(0.25));
            assert_eq!(report.ending().unwrap(), Ending::Refused);
        }
    }

    #[test]
    fn every_end_has_its_exit_code() {
        let cases = [
            (PlanEnd::Found, None, 0),
            (PlanEnd::Found, Some(DeliveryEnd::Accepted), 0),
            (PlanEnd::Found, Some(DeliveryEnd::Refused), 4),
            (PlanEnd::Found, Some(DeliveryEnd::ControllerLost), 2),
            (PlanEnd::NoPlan, None, 3),
            (PlanEnd::StartInvalid, None, 2),
            (PlanEnd::GoalInvalid, None, 2),
        ];
        for (end, delivery, code) in cases {
            let mut report = Report::default();
            report.note(&planned(end));
            delivery.iter().for_each(|delivery| report.note(&delivered(*delivery, 7)));
            assert_eq!(
                report.ending().map_or_else(|failure| failure.code(), Ending::code),
                code,
                "{end:?} {delivery:?}"
            );
        }
    }

    #[test]
    fn chunks_that_nobody_accepted_are_lost() {
        let mut report = Report::default();
        report.note(&delivered(DeliveryEnd::ControllerLost, 5));
        assert_eq!(
            (report.chunks.sent, report.chunks.lost, report.outcome.as_str()),
            (7, 2, "controller_lost")
        );
    }

    #[test]
    fn chunks_of_a_plan_that_was_given_up_are_not_lost() {
        let Line::Delivered(replanned) = delivered(DeliveryEnd::Accepted, 5) else {
            panic!("another line")
        };
        let mut report = Report::default();
        report.note(&Line::Delivered(Delivered { withdrawn: 2, ..replanned }));
        assert_eq!((report.chunks.sent, report.chunks.accepted, report.chunks.lost), (7, 5, 0));
    }
}
