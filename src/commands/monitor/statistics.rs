//! Statistics of a monitor: events, rates, latencies.

use std::collections::BTreeMap;

use serde::Serialize;
use surefoot_shared_types::message::{
    Check, Description, Feedback, PlanChunk, PlanStatus, RequestState, SimulationState, Verdict,
};

use crate::commands::monitor::motion::{StateStats, StateSummary};
use crate::commands::monitor::seen_plan::SeenPlan;
use crate::report::binding::{BindingShare, describe};
use crate::report::event::describe_stops;
use crate::report::margins::WorstMargins;
use crate::report::walk_facts::WalkFacts;

/// Most latencies that are kept for the quantiles.
const LATENCIES_MAX: usize = 4096;

/// An event that the monitor prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub(crate) enum MonitorEvent {
    /// The first message of a planner process.
    Planner { seconds: f64, session: String },
    /// The first message of a controller process.
    Controller { seconds: f64, controller_id: String, next_sequence: u64 },
    /// A new plan, or a new epoch of the same plan.
    Plan { seconds: f64, plan_id: u64, epoch: u64 },
    /// A chunk is refused.
    Refused { seconds: f64, sequence: u64, check: String, waypoint: u32, corrections: u32 },
    /// The last chunk of the plan is accepted.
    Finished {
        seconds: f64,
        chunks: u64,
        walk: WalkFacts,
        binding: Vec<BindingShare>,
        margins: WorstMargins,
    },
    /// The state of a request to a planner that serves requests.
    Request { seconds: f64, client: String, number: u64, state: String },
    /// Statistics since the last summary.
    Summary(Summary),
}

/// Statistics of one period.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Summary {
    /// Time since the monitor's start, s.
    seconds: f64,
    /// Chunks accepted so far.
    accepted: u64,
    /// Chunks that were sent and that the monitor missed, so far.
    missed_chunks: u64,
    /// Chunks seen per second.
    chunks_per_second: f64,
    /// Feedback messages received per second.
    feedback_per_second: f64,
    /// Time from a chunk's publication to its verdict, as the monitor observes it, s: median, 95 %
    /// quantile, maximum.
    verdict_latency: Option<[f64; 3]>,
    /// How often the robot had to stop because a chunk was not there, so far.
    brakes: u64,
    /// How long it stood for that reason, s.
    stood_seconds: f64,
    /// What binds the motion of the chunks so far, the longest first.
    binding: Vec<BindingShare>,
    /// The worst margins so far.
    margins: WorstMargins,
    /// Statistics of the simulated robot, where the controller publishes its state.
    state: Option<StateSummary>,
}

/// Statistics of the messages received so far.
#[derive(Debug, Default)]
pub(crate) struct MonitorStats {
    last: LastSeen,
    accepted: u64,
    plan: SeenPlan,
    /// The robot's description, once it has come.
    description: Option<Box<Description>>,
    /// Chunks since the last summary.
    chunks: u64,
    /// Feedback messages since the last summary.
    feedback_count: u64,
    /// Times at which the chunks without a verdict were first seen, by sequence number, s.
    published: BTreeMap<u64, f64>,
    latencies: Vec<f64>,
    /// The stops that the last feedback states: their number and duration (s).
    stops: (u64, f64),
    margins: WorstMargins,
    state_stats: StateStats,
}

/// The identities that were seen last. An event is printed when one of them changes.
#[derive(Debug, Default)]
struct LastSeen {
    session: Option<u64>,
    controller_id: Option<u64>,
    /// Plan id and epoch.
    plan: Option<(u64, u64)>,
    /// Client, number and state.
    request: Option<(u64, u64, u32)>,
    /// Plan id and epoch of the last refusal.
    refused: Option<(u64, u64)>,
    /// Plan id and epoch of the last plan that was accepted completely.
    finished: Option<(u64, u64)>,
}

impl MonitorStats {
    /// Whether any message was received.
    pub(crate) fn has_received(&self) -> bool {
        self.last.session.is_some()
            || self.last.controller_id.is_some()
            || self.last.request.is_some()
    }

    /// Records a chunk that arrived at `seconds`.
    pub(crate) fn record_chunk(&mut self, chunk: &PlanChunk, seconds: f64) -> Vec<MonitorEvent> {
        let mut events = vec![];
        self.chunks += 1;
        if self.last.session.replace(chunk.session) != Some(chunk.session) {
            events.push(MonitorEvent::Planner {
                seconds,
                session: format!("{:016x}", chunk.session),
            });
        }
        events.extend(self.switch_plan((chunk.plan_id, chunk.epoch), seconds));
        if self.last.plan == Some((chunk.plan_id, chunk.epoch)) {
            self.plan.record(chunk);
        }
        if chunk.sequence >= self.accepted {
            self.published.entry(chunk.sequence).or_insert(seconds);
        }
        events
    }

    /// Records feedback that arrived at `seconds`.
    pub(crate) fn record_feedback(
        &mut self,
        feedback: &Feedback,
        seconds: f64,
    ) -> Vec<MonitorEvent> {
        let mut events = vec![];
        self.feedback_count += 1;
        if self.last.controller_id.replace(feedback.controller_id) != Some(feedback.controller_id) {
            events.push(MonitorEvent::Controller {
                seconds,
                controller_id: format!("{:016x}", feedback.controller_id),
                next_sequence: feedback.next_sequence,
            });
        }
        if feedback.session == 0 {
            return events;
        }
        let plan = (feedback.plan_id, feedback.epoch);
        events.extend(self.switch_plan(plan, seconds));
        self.record_progress(feedback, seconds);
        if feedback.verdict == Verdict::Refused as u32
            && self.last.refused.replace(plan) != Some(plan)
        {
            let check = Check::from_wire(feedback.check).map_or("unknown", Check::name).to_owned();
            let (sequence, waypoint, corrections) =
                (feedback.refused_sequence, feedback.refused_waypoint, feedback.corrections_len);
            events.push(MonitorEvent::Refused { seconds, sequence, check, waypoint, corrections });
        }
        if feedback.finished == 1 && self.last.finished.replace(plan) != Some(plan) {
            events.push(MonitorEvent::Finished {
                seconds,
                chunks: feedback.next_sequence,
                walk: self.plan.walk(),
                binding: self.binding(),
                margins: self.margins,
            });
        }
        events
    }

    /// Records a status of a planner that serves requests.
    pub(crate) fn record_status(
        &mut self,
        status: &PlanStatus,
        seconds: f64,
    ) -> Option<MonitorEvent> {
        let record = &status.current;
        let state = RequestState::from_wire(record.state)?;
        let request = (record.client, record.number, record.state);
        let is_new = record.client != 0 && self.last.request.replace(request) != Some(request);
        is_new.then(|| MonitorEvent::Request {
            seconds,
            client: format!("{:016x}", record.client),
            number: record.number,
            state: state.name().into(),
        })
    }

    /// Takes the names of the joints.
    pub(crate) fn record_description(&mut self, description: Description) {
        self.description = Some(Box::new(description));
    }

    /// What binds the plan's motion so far.
    fn binding(&self) -> Vec<BindingShare> {
        self.plan.binding(self.description.as_deref())
    }

    /// Records a state of the simulated robot.
    pub(crate) fn record_state(&mut self, state: &SimulationState) {
        self.state_stats.record(state);
    }

    /// The summary of the last `period` (s), of a monitor that missed so many chunks in all. Starts
    /// a new period.
    pub(crate) fn summary(
        &mut self,
        seconds: f64,
        period: f64,
        missed_chunks: u64,
    ) -> MonitorEvent {
        let rate = |count: u64| if period > 0.0 { count as f64 / period } else { 0.0 };
        let summary = Summary {
            seconds,
            accepted: self.accepted,
            missed_chunks,
            chunks_per_second: rate(self.chunks),
            feedback_per_second: rate(self.feedback_count),
            verdict_latency: quantiles(&mut self.latencies),
            brakes: self.stops.0,
            stood_seconds: self.stops.1,
            binding: self.binding(),
            margins: self.margins,
            state: self.state_stats.summary(period),
        };
        (self.chunks, self.feedback_count) = (0, 0);
        MonitorEvent::Summary(summary)
    }

    fn switch_plan(&mut self, plan: (u64, u64), seconds: f64) -> Option<MonitorEvent> {
        if self.last.plan >= Some(plan) {
            return None;
        }
        self.last.plan = Some(plan);
        self.accepted = 0;
        self.plan = SeenPlan::default();
        self.published.clear();
        Some(MonitorEvent::Plan { seconds, plan_id: plan.0, epoch: plan.1 })
    }

    fn record_progress(&mut self, feedback: &Feedback, seconds: f64) {
        while self
            .published
            .first_key_value()
            .is_some_and(|(sequence, _)| *sequence < feedback.next_sequence)
        {
            if let Some((_, published)) = self.published.pop_first()
                && self.latencies.len() < LATENCIES_MAX
            {
                self.latencies.push(seconds - published);
            }
        }
        self.accepted = feedback.next_sequence;
        self.stops = (feedback.brakes, feedback.stood);
        self.margins = WorstMargins::from(&feedback.margins);
    }
}

/// What binds, as a part of a line of text.
fn bound_by(binding: &[BindingShare]) -> String {
    let text = describe(binding);
    if text.is_empty() { text } else { format!("; bound by {text}") }
}

fn quantiles(latencies: &mut [f64]) -> Option<[f64; 3]> {
    latencies.sort_by(f64::total_cmp);
    let last = latencies.len().checked_sub(1)?;
    Some([last / 2, last * 95 / 100, last].map(|index| latencies[index]))
}

impl MonitorEvent {
    /// The event as one line of text.
    pub(crate) fn line(&self) -> String {
        match self {
            Self::Planner { seconds, session } => {
                format!("{seconds:9.3} s  planner {session} connected")
            }
            Self::Controller { seconds, controller_id, next_sequence } => {
                format!(
                    "{seconds:9.3} s  controller {controller_id} connected, {next_sequence} chunks accepted"
                )
            }
            Self::Plan { seconds, plan_id, epoch } => {
                format!("{seconds:9.3} s  plan {plan_id}, epoch {epoch}")
            }
            Self::Refused { seconds, sequence, check, waypoint, corrections } => {
                format!(
                    "{seconds:9.3} s  refused: {check} at waypoint {waypoint} of chunk {sequence}, {corrections} corrections so far"
                )
            }
            Self::Finished { seconds, chunks, walk, binding, margins } => {
                format!(
                    "{seconds:9.3} s  finished: {chunks} chunks accepted; walk: {}{}; margins: {}",
                    walk.describe(),
                    bound_by(binding),
                    margins.describe()
                )
            }
            Self::Request { seconds, client, number, state } => {
                format!("{seconds:9.3} s  request {number} of client {client}: {state}")
            }
            Self::Summary(summary) => summary.line(),
        }
    }

    /// One JSON object in a line.
    pub(crate) fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl Summary {
    fn line(&self) -> String {
        let rates = format!(
            "{:.1} chunks/s ({} missed), {:.0} feedback/s",
            self.chunks_per_second, self.missed_chunks, self.feedback_per_second
        );
        let latency = self.verdict_latency.map_or(String::new(), |[p50, p95, max]| {
            format!(
                ", verdict after {:.2} ms (p95 {:.2}, max {:.2})",
                1000.0 * p50,
                1000.0 * p95,
                1000.0 * max
            )
        });
        let margins = self.margins.describe();
        let margins = if margins.is_empty() { margins } else { format!("; margins: {margins}") };
        let state = self.state.map_or(String::new(), |state| format!("; {}", state.describe()));
        let stops = describe_stops(0, self.brakes, self.stood_seconds);
        let stops = stops.map_or(String::new(), |stops| format!("; {stops}"));
        format!(
            "{:9.3} s  {} accepted, {rates}{latency}{}{margins}{stops}{state}",
            self.seconds,
            self.accepted,
            bound_by(&self.binding)
        )
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn latencies_run_from_a_chunks_first_arrival_to_its_verdict() {
        let mut stats = MonitorStats::default();
        let chunk =
            |sequence| PlanChunk { session: 5, plan_id: 1, sequence, ..PlanChunk::zeroed() };
        let feedback = |next_sequence| Feedback {
            controller_id: 6,
            session: 5,
            plan_id: 1,
            next_sequence,
            ..Feedback::zeroed()
        };
        assert_eq!(stats.record_chunk(&chunk(0), 1.0).len(), 2, "a planner and a plan");
        assert_eq!(stats.record_chunk(&chunk(1), 1.1).len(), 0);
        stats.record_chunk(&chunk(0), 1.2);
        assert_eq!(stats.record_feedback(&feedback(0), 1.25).len(), 1, "a controller");
        let stopped = Feedback { brakes: 2, stood: 3.12, ..feedback(2) };
        stats.record_feedback(&stopped, 1.5);
        let MonitorEvent::Summary(summary) = stats.summary(2.0, 1.0, 3) else {
            panic!("no summary")
        };
        let [p50, _, max] = summary.verdict_latency.unwrap();
        assert!((p50 - 0.4).abs() < 1e-9 && (max - 0.5).abs() < 1e-9, "{summary:?}");
        assert_eq!(
            (summary.accepted, summary.chunks_per_second, summary.feedback_per_second),
            (2, 3.0, 2.0)
        );
        assert!(summary.line().contains("3.0 chunks/s (3 missed)"), "{}", summary.line());
        assert!(summary.line().contains("; braked 2 times, stood 3.1 s"), "{}", summary.line());
    }

    #[test]
    fn results_are_reported_once_in_each_epoch() {
        let mut stats = MonitorStats::default();
        let refused = Feedback {
            controller_id: 6,
            session: 5,
            plan_id: 1,
            verdict: 2,
            check: 16,
            ..Feedback::zeroed()
        };
        let ends = |stats: &mut MonitorStats, feedback: &Feedback| {
            stats
                .record_feedback(feedback, 1.0)
                .into_iter()
                .filter(|event| {
                    matches!(event, MonitorEvent::Refused { .. } | MonitorEvent::Finished { .. })
                })
                .count()
        };
        assert_eq!((ends(&mut stats, &refused), ends(&mut stats, &refused)), (1, 0));
        let again = Feedback { epoch: 1, ..refused };
        assert_eq!(ends(&mut stats, &again), 1);
        let finished = Feedback { verdict: 1, finished: 1, ..again };
        assert_eq!((ends(&mut stats, &finished), ends(&mut stats, &finished)), (1, 0));
    }
}
