//! The subscriber's state in the stream, and the triage of a received chunk before its content is
//! checked.
//!
//! The CRC comes first; no field is used until it matches, and a damaged chunk is dropped: nothing
//! in it says who sent it. The content of a chunk is checked only if the chunk is for this
//! controller, of the current planner session, of the plan in execution, and the next one.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::instance::sender::{SenderStatus, SenderTracker};
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{
    Check, Feedback, JournalRecord, Margins, PlanChunk, RestState, Verdict, WalkRecord, WithCrc,
    WorldCorrection,
};

use crate::execution::plan_clock::StopCounts;

/// A refused chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal {
    /// The sequence number of the refused chunk, which was expected next.
    pub sequence: u64,
    /// The violated check.
    pub check: Check,
    /// The waypoint of the violation.
    pub waypoint: u32,
}

/// Counters of the chunks received since the instance's start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReceiverStats {
    /// All of them.
    pub received: u64,
    /// Checked and accepted.
    pub accepted: u64,
    /// Accepted before, and not executed again.
    pub duplicates: u64,
    /// Ahead of a chunk that is still missing, and ignored: the planner sends them again.
    pub gaps: u64,
    /// Of a planner session or plan that is over.
    pub stale: u64,
    /// Meant for another controller.
    pub foreign: u64,
    /// Damaged: their CRC is not that of their bytes. The planner sends its own again.
    pub damaged: u64,
    /// Of publishers other than the planner's: forged, or left over from a planner before.
    pub other_senders: u64,
}

/// What the robot does with the accepted chunks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WalkProgress {
    /// Whether it moves.
    pub is_moving: bool,
    /// Its stops under this controller.
    pub stops: StopCounts,
}

/// What to do with a received chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChunkTriage {
    /// It is the next one: check its content.
    Check,
    /// It does not continue the stream: refuse it for this reason.
    Refuse(Check),
    /// Nothing: damaged, a duplicate, a gap, stale, for another controller, or after a refusal.
    Ignore,
}

/// The subscriber's state in the stream.
#[derive(Debug, Clone)]
pub(crate) struct StreamState {
    controller_id: u64,
    sessions: SenderTracker,
    progress: PlanProgress,
    rest_state: RestState,
    /// Chunks that the robot executed since its start.
    walked: u64,
    /// The stops under the controllers before.
    stops_before: StopCounts,
    corrections: heapless::Vec<WorldCorrection, CORRECTIONS_MAX>,
    /// Whether a chunk is being checked.
    busy: bool,
    stats: ReceiverStats,
}

/// The accepted part of the plan in execution.
#[derive(Debug, Clone)]
struct PlanProgress {
    /// The plan's id and epoch.
    plan: Option<(u64, u64)>,
    /// The sequence number expected next.
    next: u64,
    /// Digest of the accepted stream.
    stream: Digest,
    /// Digest of the stream after its first chunk.
    stream_after_first: Digest,
    /// Whether the last chunk is accepted.
    finished: bool,
    refusal: Option<Refusal>,
    /// The worst margins of the accepted chunks.
    margins: Margins,
}

impl PlanProgress {
    /// No plan has begun.
    fn none() -> Self {
        Self {
            plan: None,
            next: 0,
            stream: Digest::default(),
            stream_after_first: Digest::default(),
            finished: false,
            refusal: None,
            margins: Margins::UNMEASURED,
        }
    }

    /// The progress that a controller recorded.
    fn of_record(record: &JournalRecord) -> Self {
        let feedback = &record.feedback;
        let is_refused = feedback.verdict == Verdict::Refused as u32;
        let refusal = Check::from_wire(feedback.check).filter(|_| is_refused);
        Self {
            plan: (feedback.session != 0).then_some((feedback.plan_id, feedback.epoch)),
            next: feedback.next_sequence,
            stream: feedback.stream,
            stream_after_first: record.stream_after_first,
            finished: feedback.finished != 0,
            refusal: refusal.map(|check| Refusal {
                sequence: feedback.refused_sequence,
                check,
                waypoint: feedback.refused_waypoint,
            }),
            margins: feedback.margins,
        }
    }

    /// The start of a chunk's plan. The stream digests keep their values until a chunk is accepted.
    fn begin(&mut self, chunk: &PlanChunk) {
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next = 0;
        self.finished = false;
        self.refusal = None;
        self.margins = Margins::UNMEASURED;
    }

    /// The checked chunk is accepted, with which the stream has digest `stream`.
    fn accept(&mut self, chunk: &PlanChunk, stream: Digest, margins: &Margins) {
        self.stream = stream;
        if self.next == 0 {
            self.stream_after_first = stream;
        }
        self.next += 1;
        self.finished = chunk.flags & FLAG_LAST != 0;
        self.margins = self.margins.min(margins);
    }

    fn is_of_plan(&self, chunk: &PlanChunk) -> bool {
        self.plan == Some((chunk.plan_id, chunk.epoch))
    }

    /// Whether a chunk of a new session begins a stream other than the one in execution. A
    /// restarted planner that made the same plan again does not.
    fn begins_other_stream(&self, chunk: &PlanChunk) -> bool {
        let repeats_ours = self.is_of_plan(chunk)
            && self.next > 0
            && chunk.stream_after() == self.stream_after_first;
        chunk.sequence == 0 && !repeats_ours
    }

    fn verdict(&self) -> Verdict {
        match (self.refusal, self.next) {
            (Some(_), _) => Verdict::Refused,
            (None, 0) => Verdict::Waiting,
            (None, _) => Verdict::Accepted,
        }
    }
}

impl StreamState {
    /// The state before the first chunk.
    pub(crate) fn new(controller_id: u64) -> Self {
        Self {
            controller_id,
            sessions: SenderTracker::default(),
            progress: PlanProgress::none(),
            rest_state: bytemuck::Zeroable::zeroed(),
            walked: 0,
            stops_before: StopCounts::default(),
            corrections: heapless::Vec::new(),
            busy: false,
            stats: ReceiverStats::default(),
        }
    }

    /// The state in which the previous controller left the robot. `walk` says where it was.
    pub(crate) fn take_over(
        controller_id: u64,
        record: &JournalRecord,
        walk: Option<&WalkRecord>,
    ) -> Self {
        let feedback = &record.feedback;
        let mut sessions = SenderTracker::default();
        if feedback.session != 0 {
            sessions.adopt(feedback.session);
        }
        Self {
            controller_id,
            sessions,
            progress: PlanProgress::of_record(record),
            rest_state: feedback.rest_state,
            walked: feedback.walked,
            stops_before: walk
                .map_or(StopCounts { brakes: feedback.brakes, stood: feedback.stood }, |walk| {
                    StopCounts { brakes: walk.brakes, stood: walk.stood }
                }),
            corrections: feedback.corrections().iter().copied().collect(),
            busy: false,
            stats: ReceiverStats {
                accepted: feedback.next_sequence,
                duplicates: feedback.duplicated,
                gaps: feedback.gaps,
                ..ReceiverStats::default()
            },
        }
    }

    /// Digest of the stream after its first chunk, which identifies the plan of a restarted
    /// planner.
    pub(crate) fn stream_after_first(&self) -> Digest {
        self.progress.stream_after_first
    }

    /// Counts a chunk that the planner did not send; nothing in it is used.
    pub(crate) fn ignore_other_sender(&mut self) {
        self.stats.received += 1;
        self.stats.other_senders += 1;
    }

    /// Decides what to do with a chunk, counts it, and moves to a new planner session or plan where
    /// it begins one.
    pub(crate) fn triage(&mut self, chunk: &PlanChunk) -> ChunkTriage {
        self.stats.received += 1;
        if !chunk.crc_matches() {
            self.stats.damaged += 1;
            return ChunkTriage::Ignore;
        }
        if chunk.target_controller != self.controller_id {
            self.stats.foreign += 1;
            return ChunkTriage::Ignore;
        }
        match self.sessions.status(chunk.session) {
            SenderStatus::Stale => return self.ignore_stale(),
            SenderStatus::New if self.progress.begins_other_stream(chunk) => self.begin_plan(chunk),
            SenderStatus::New if self.progress.is_of_plan(chunk) => {
                self.sessions.adopt(chunk.session)
            }
            SenderStatus::New => return self.ignore_gap(),
            SenderStatus::Current if self.progress.is_of_plan(chunk) => {}
            SenderStatus::Current
                if chunk.sequence == 0
                    && Some((chunk.plan_id, chunk.epoch)) > self.progress.plan =>
            {
                self.begin_plan(chunk)
            }
            SenderStatus::Current => return self.ignore_stale(),
        }
        self.triage_sequence(chunk)
    }

    /// The checked chunk is accepted, with which the stream has digest `stream`; `executed` is the
    /// chunk as the robot executed it.
    pub(crate) fn accept(
        &mut self,
        chunk: &PlanChunk,
        stream: Digest,
        margins: &Margins,
        executed: &PlanChunk,
    ) {
        self.progress.accept(chunk, stream, margins);
        let is_empty = executed.waypoints().is_empty();
        let rest = if is_empty {
            self.rest_state.waypoint
        } else {
            crate::check::course::Stop::rest(executed)
        };
        self.rest_state = self.rest_state.after(executed.mode, executed.contacts(), &rest);
        self.walked += 1;
        self.stats.accepted += 1;
    }

    /// The chunk at the current sequence number is refused; no further chunk of this stream is
    /// checked. A correction beyond [`CORRECTIONS_MAX`] is not reported.
    pub(crate) fn refuse(
        &mut self,
        check: Check,
        waypoint: u32,
        correction: Option<WorldCorrection>,
    ) {
        self.progress.refusal = Some(Refusal { sequence: self.progress.next, check, waypoint });
        if let Some(correction) = correction {
            let _ = self.corrections.push(correction);
        }
    }

    /// Whether a chunk is being checked.
    pub(crate) fn set_busy(&mut self, busy: bool) {
        self.busy = busy;
    }

    /// The refusal that holds, if any.
    pub(crate) fn refusal(&self) -> Option<Refusal> {
        self.progress.refusal
    }

    /// Chunks that the robot executed since its start.
    pub(crate) fn walked(&self) -> u64 {
        self.walked
    }

    /// Whether the plan's last chunk is accepted.
    pub(crate) fn is_finished(&self) -> bool {
        self.progress.finished
    }

    /// Whether a plan has begun and is neither finished nor refused.
    pub(crate) fn is_mid_plan(&self) -> bool {
        self.progress.next > 0 && !self.progress.finished && self.progress.refusal.is_none()
    }

    /// Counters of the received chunks.
    pub(crate) fn stats(&self) -> ReceiverStats {
        self.stats
    }

    /// The `count`th feedback to the planner, of a robot that walks like this.
    pub(crate) fn feedback(&self, count: u64, walk: WalkProgress) -> Feedback {
        let progress = &self.progress;
        let StopCounts { brakes, stood } = self.stops_before.plus(walk.stops);
        let (plan_id, epoch) = progress.plan.unwrap_or_default();
        let refusal = progress.refusal;
        let mut corrections = [bytemuck::Zeroable::zeroed(); CORRECTIONS_MAX];
        corrections[..self.corrections.len()].copy_from_slice(&self.corrections);
        let mut feedback = Feedback {
            schema: FEEDBACK_SCHEMA,
            controller_id: self.controller_id,
            session: self.sessions.current().unwrap_or(0),
            plan_id,
            epoch,
            next_sequence: progress.next,
            count,
            verdict: progress.verdict() as u32,
            check: refusal.map_or(0, |refusal| refusal.check as u32),
            refused_sequence: refusal.map_or(0, |refusal| refusal.sequence),
            refused_waypoint: refusal.map_or(0, |refusal| refusal.waypoint),
            finished: u32::from(progress.finished),
            duplicated: self.stats.duplicates,
            gaps: self.stats.gaps,
            walked: self.walked,
            brakes,
            stood,
            busy: u32::from(self.busy),
            corrections_len: self.corrections.len() as u32,
            moving: u32::from(walk.is_moving),
            crc: 0,
            stream: progress.stream,
            margins: progress.margins,
            rest_state: self.rest_state,
            corrections,
        };
        feedback.write_crc();
        feedback
    }

    fn begin_plan(&mut self, chunk: &PlanChunk) {
        self.sessions.adopt(chunk.session);
        self.progress.begin(chunk);
    }

    fn triage_sequence(&mut self, chunk: &PlanChunk) -> ChunkTriage {
        let progress = &self.progress;
        if chunk.sequence < progress.next {
            self.stats.duplicates += 1;
            return ChunkTriage::Ignore;
        }
        if chunk.sequence > progress.next || progress.finished {
            return self.ignore_gap();
        }
        if self.progress.refusal.is_some() {
            return ChunkTriage::Ignore;
        }
        let continues = progress.next == 0 || chunk.stream == progress.stream;
        if continues { ChunkTriage::Check } else { ChunkTriage::Refuse(Check::Stream) }
    }

    fn ignore_gap(&mut self) -> ChunkTriage {
        self.stats.gaps += 1;
        ChunkTriage::Ignore
    }

    fn ignore_stale(&mut self) -> ChunkTriage {
        self.stats.stale += 1;
        ChunkTriage::Ignore
    }
}

#[cfg(test)]
mod tests;
