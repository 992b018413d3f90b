//! The events of the planner and the controller process: one JSON object a line on stdout.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use surefoot_controller_sim::channel::Refusal as RefusedChunk;
use surefoot_planner::Outcome;
use surefoot_planner::channel::plan_publisher::Delivery;
use surefoot_planner::channel::send_window::DeliveryOutcome;

use crate::report::binding::BindingShare;
use crate::report::margins::WorstMargins;
use crate::report::walk_facts::WalkFacts;

/// An event that a role process reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum RoleEvent {
    /// The planner has all its memory.
    PlannerReady {
        /// Time it took, s.
        ready_seconds: f64,
        /// Size of all arenas.
        arena_bytes: u64,
    },
    /// The planner searches.
    Planning(SearchProgress),
    /// The planner has a plan, and improves it; a signal ends that with the best plan so far.
    Improving {
        /// Duration of the first plan, s.
        first_seconds: f64,
    },
    /// The planner is done searching.
    Planned(Planned),
    /// The controller accepted further chunks.
    Delivering {
        /// Chunks accepted.
        accepted: u64,
        /// Chunks of the plan.
        chunks: u64,
    },
    /// The planner is done delivering.
    Delivered(Delivered),
    /// The controller listens.
    ControllerReady,
    /// The controller has checked the plan.
    Checked(CheckSummary),
    /// The rest of the plan is planned again from the robot's rest state.
    Replanning {
        /// The new epoch.
        epoch: u64,
        /// Known differences of the world.
        corrections: u64,
    },
    /// No plan was found from the rest state; the planner searches for one that retraces first.
    Retracing,
    /// The planner waits for requests.
    PlannerServes,
    /// No planner is connected; the robot holds its position at the end of the last executed chunk.
    Holding {
        /// Chunks accepted.
        accepted: u64,
    },
    /// The supervisor started a process again.
    Restarted {
        /// Which.
        role: String,
        /// How the one before ended.
        how: String,
    },
    /// The process runs. Emitted every second.
    Alive,
    /// The process cannot go on.
    Failed {
        /// Whether the transport failed, so that a restart may help.
        #[serde(default)]
        is_transport: bool,
        /// The reason and what to do, one line.
        message: String,
    },
}

/// The progress of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchProgress {
    /// Work units used.
    pub work: u64,
    /// Work units that may be used.
    pub work_max: u64,
    /// Sequences tried.
    pub sequences: u64,
    /// Transitions with a configuration.
    pub transitions: u64,
    /// Motions found.
    pub motions: u64,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// Kind of result.
    pub result: PlanResult,
    /// The outcome's name.
    pub outcome: String,
    /// The parameter that ended it, if one did.
    pub bound: Option<String>,
    /// The outcome as one line of text.
    pub description: String,
    /// Digest of the chunk stream, if there is one.
    pub digest: Option<String>,
    /// Time it took, s.
    pub plan_seconds: f64,
    /// Time until the first chunk was final, s.
    #[serde(default)]
    pub first_chunk_seconds: Option<f64>,
    /// Work units used.
    pub work: u64,
    /// Sequences tried.
    pub sequences: u64,
    /// The diagnosis of a search without a plan.
    pub diagnosis: Option<Box<Diagnosis>>,
    /// Edges of the guide route.
    pub route_edges: u64,
    /// Edges of the guide route that are possible: primitives lead along.
    pub route_edges_possible: u64,
    /// Motions that were primitives.
    pub primitives: u64,
    /// Heap allocations during the search.
    pub allocations: u64,
    /// Steps of the plan.
    pub steps: u64,
    /// Waypoints of the plan.
    pub waypoints: u64,
    /// Chunks of the plan.
    pub chunks: u64,
    /// The plan as a walk, if there is one.
    #[serde(default)]
    pub walk: Option<WalkFacts>,
    /// Counts of a smooth motion; none of a quasi-static one.
    pub smooth: Option<Box<SmoothMotion>>,
    /// What the improvement of the plan came to, if it was improved.
    #[serde(default)]
    pub improved: Option<Improved>,
}

/// What the improvement of a plan came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Improved {
    /// Work units until the first plan.
    pub first_work: u64,
    /// Work units after it.
    pub work: u64,
    /// Duration of the first plan, s.
    pub first_seconds: f64,
    /// Duration of the plan, s.
    pub seconds: f64,
    /// Other walks that were tried.
    pub rounds: u64,
    /// Walks that took less time than the best one before.
    pub kept: u64,
    /// Whether a signal or another request ended it before all its work.
    #[serde(default)]
    pub stopped: bool,
}

impl Improved {
    /// One line of text.
    pub fn describe(&self) -> String {
        let Self { first_work, work, first_seconds, seconds, rounds, kept, stopped } = *self;
        let end = if stopped { ", then stopped" } else { "" };
        format!(
            "{first_seconds:.1} s to {seconds:.1} s in {rounds} rounds, {kept} of them kept; \
             {work} work units after {first_work}{end}"
        )
    }
}

/// Where a smooth motion is not as smooth or fast as elsewhere, and what binds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SmoothMotion {
    /// How often the robot rests on the way.
    pub rests: u64,
    /// Phases that keep the searched motion, from rest to rest.
    pub searched_phases: u64,
    /// Points of the path at which the robot cannot stand within the full margins of timing, but
    /// within smaller ones.
    pub relaxed_points: u64,
    /// Points at which no contact forces within the limits are known.
    pub beyond_limits: u64,
    /// Chunks in which the robot cannot stop within the limits.
    pub without_stop: u64,
    /// Pieces without a timing within the limits: the robot rests at their waypoints.
    #[serde(default)]
    pub untimed_pieces: u64,
    /// What binds the motion, the longest first.
    #[serde(default)]
    pub binding: Vec<BindingShare>,
    /// Share of the time in which the motion is slower than its rates allow, because the rounded
    /// motion or a stop was beyond a limit.
    #[serde(default)]
    pub slowed_share: f64,
}

impl SmoothMotion {
    /// The counts in one line.
    pub fn describe(&self) -> String {
        let Self { rests, searched_phases, relaxed_points, beyond_limits, without_stop, .. } = self;
        let mut text = format!(
            "smooth; {rests} rests, {searched_phases} searched phases, {relaxed_points} points with \
             smaller margins, {beyond_limits} beyond the limits, {without_stop} chunks without a stop"
        );
        if self.untimed_pieces > 0 {
            text += &format!(", {} pieces without a timing", self.untimed_pieces);
        }
        text
    }
}

/// The diagnosis of a search without a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Whether stage P found no guide route, so that a straight route was tried.
    pub used_straight_line: bool,
    /// Guide routes tried.
    pub routes: u64,
    /// Where most sequences failed.
    pub bottleneck: Option<Bottleneck>,
    /// Configurations and motions that were rejected, by reason.
    pub rejections: BTreeMap<String, u64>,
    /// The links that collide most often as the robot shifts its weight, where self-collisions are
    /// a main reason.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colliding: Option<CollidingLinks>,
}

/// Two links of the robot that collide, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CollidingLinks {
    /// Which, in words.
    pub links: String,
    /// The share of postures with both feet as they stand in which they do, %.
    pub percent: f64,
}

impl CollidingLinks {
    /// One line of text.
    pub fn describe(&self) -> String {
        format!("{} in {:.0} % of postures as it shifts its weight", self.links, self.percent)
    }
}

/// Where most sequences of a search failed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bottleneck {
    /// Between the feet, in the world, m.
    pub xyz: [f64; 3],
    /// Sequences that failed there.
    pub failures: u64,
}

/// Kinds of results of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanResult {
    /// A plan.
    Found,
    /// A bound, or a task that is impossible.
    NoPlan,
    /// A start where the robot cannot stand.
    StartInvalid,
    /// A goal where the robot cannot stand.
    GoalInvalid,
    /// A signal came first.
    Stopped,
}

impl From<&Outcome> for PlanResult {
    fn from(outcome: &Outcome) -> Self {
        match outcome {
            Outcome::Found => Self::Found,
            Outcome::BudgetExhausted(_)
            | Outcome::ArenaFull(_)
            | Outcome::Impossible(_)
            | Outcome::NotExpressible(_)
            | Outcome::MethodExhausted(_)
            | Outcome::NoContinuation => Self::NoPlan,
            Outcome::StartInvalid(_) => Self::StartInvalid,
            Outcome::GoalInvalid(_) => Self::GoalInvalid,
        }
    }
}

/// Result of a delivery, as the planner saw it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Delivered {
    /// Kind of result.
    pub result: DeliveryResult,
    /// Chunks put into shared memory, those sent again included.
    pub sent: u64,
    /// Chunks sent again.
    pub resent: u64,
    /// Chunks accepted.
    pub accepted: u64,
    /// Chunks on their way when their plan was replaced by another one.
    pub withdrawn: u64,
    /// Chunks that the controller received again after it had accepted them.
    pub duplicated: u64,
    /// Feedback messages of publishers other than the controller's, which were dropped.
    #[serde(default)]
    pub feedback_dropped: u64,
    /// The worst margins that the controller reported.
    pub margins: WorstMargins,
    /// The refusal, if there was one.
    pub refusal: Option<Refusal>,
    /// Time from the beginning of the last search until its first chunk was sent, s.
    #[serde(default)]
    pub first_chunk_seconds: Option<f64>,
}

/// Kinds of results of a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeliveryResult {
    /// Every chunk is accepted.
    Accepted,
    /// Every chunk is accepted, but the rest of the plan could not be made.
    Incomplete,
    /// A chunk is refused.
    Refused,
    /// The controller executes a later plan of another planner.
    Superseded,
    /// The controller does not answer.
    ControllerLost,
    /// Two processes publish feedback as the controller.
    Contradicted,
    /// This process was asked to end.
    Stopped,
}

/// A refused chunk.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// The violated check.
    pub check: String,
    /// The chunk.
    pub sequence: u64,
    /// Where in the chunk.
    pub waypoint: u32,
    /// The violation, its amount and the limit; empty if the controller did not report them.
    pub detail: String,
}

impl Refusal {
    /// A refusal as the controller sees it.
    pub fn of(chunk: RefusedChunk, detail: String) -> Self {
        Self {
            check: chunk.check.name().to_owned(),
            sequence: chunk.sequence,
            waypoint: chunk.waypoint,
            detail,
        }
    }

    /// One line of text.
    pub fn describe(&self) -> String {
        let detail =
            if self.detail.is_empty() { String::new() } else { format!(": {}", self.detail) };
        format!("{} at waypoint {} of chunk {}{detail}", self.check, self.waypoint, self.sequence)
    }
}

/// Summary of the controller's checks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CheckSummary {
    /// Time spent checking, s.
    pub check_seconds: f64,
    /// Chunks accepted.
    pub accepted: u64,
    /// Chunks received again after they had been accepted.
    pub duplicated: u64,
    /// Chunks with a wrong CRC, which were dropped.
    #[serde(default)]
    pub damaged: u64,
    /// Chunks of publishers other than the planner's, which were dropped.
    #[serde(default)]
    pub other_senders: u64,
    /// Chunks that this controller held back (`--late`).
    #[serde(default)]
    pub late_chunks: u64,
    /// How often the robot had to stop because the next chunk was not there.
    #[serde(default)]
    pub brakes: u64,
    /// How long it stood for that reason, s of its own time.
    #[serde(default)]
    pub stood_seconds: f64,
    /// The worst margins of the accepted chunks.
    pub margins: WorstMargins,
    /// The refusal, if there was one.
    pub refusal: Option<Refusal>,
}

impl CheckSummary {
    /// The stops in one line; nothing if there were none.
    pub fn stops(&self) -> Option<String> {
        let Self { late_chunks, brakes, stood_seconds, .. } = *self;
        describe_stops(late_chunks, brakes, stood_seconds)
    }

    /// The dropped chunks in one line; nothing if there were none.
    pub fn dropped(&self) -> Option<String> {
        let kinds = [(self.damaged, "wrong CRC"), (self.other_senders, "another sender")];
        let count = |(count, why)| {
            let chunks = if count == 1 { "chunk" } else { "chunks" };
            (count > 0).then(|| format!("{count} {chunks} dropped ({why})"))
        };
        let dropped: Vec<String> = kinds.into_iter().filter_map(count).collect();
        (!dropped.is_empty()).then(|| dropped.join(", "))
    }
}

/// How often the robot had to stop because a chunk was not there, how long it stood (s), and how
/// many chunks were held back, in one line; nothing if none was and it did not stop.
pub fn describe_stops(late: u64, brakes: u64, stood: f64) -> Option<String> {
    let held_back = match late {
        0 => String::new(),
        late => format!("{late} chunks held back, "),
    };
    let times = if brakes == 1 { "time" } else { "times" };
    (late > 0 || brakes > 0)
        .then(|| format!("{held_back}braked {brakes} {times}, stood {stood:.1} s"))
}

impl From<&Delivery> for Delivered {
    fn from(delivery: &Delivery) -> Self {
        let (result, refusal) = match delivery.outcome {
            DeliveryOutcome::Accepted => (DeliveryResult::Accepted, None),
            DeliveryOutcome::Incomplete => (DeliveryResult::Incomplete, None),
            DeliveryOutcome::Refused { sequence, check, waypoint } => (
                DeliveryResult::Refused,
                Some(Refusal::of(RefusedChunk { sequence, check, waypoint }, String::new())),
            ),
            DeliveryOutcome::Superseded => (DeliveryResult::Superseded, None),
            DeliveryOutcome::ControllerLost => (DeliveryResult::ControllerLost, None),
            DeliveryOutcome::Contradicted => (DeliveryResult::Contradicted, None),
            DeliveryOutcome::Stopped => (DeliveryResult::Stopped, None),
        };
        Self {
            result,
            sent: delivery.sent,
            resent: delivery.resent,
            accepted: delivery.accepted,
            withdrawn: 0,
            feedback_dropped: delivery.other_senders,
            duplicated: delivery.feedback.map_or(0, |feedback| feedback.duplicated),
            margins: delivery
                .feedback
                .map(|feedback| WorstMargins::from(&feedback.margins))
                .unwrap_or_default(),
            refusal,
            first_chunk_seconds: None,
        }
    }
}
