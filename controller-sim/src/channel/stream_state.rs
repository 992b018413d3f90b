//! The subscriber's state in the stream, and the triage of a received chunk before its content is
//! checked.
//!
//! The CRC comes first; no field is used until it matches. The content of a chunk is checked only
//! if the chunk is for this controller, of the current planner session, of the plan in execution,
//! and the next one.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::instance::sender::{SenderStatus, SenderTracker};
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{
    Check, Feedback, JournalRecord, Margins, PlanChunk, RestState, Verdict, WithCrc,
    WorldCorrection,
};

use crate::channel::plan_subscriber::{ReceiverStats, Refusal};

/// What to do with a received chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ChunkTriage {
    /// It is the next one: check its content.
    Check,
    /// It is damaged or does not continue the stream: refuse it for this reason.
    Refuse(Check),
    /// Nothing: a duplicate, a gap, stale, for another controller, or after a refusal.
    Ignore,
}

/// The subscriber's state in the stream.
#[derive(Debug)]
pub(crate) struct StreamState {
    controller_id: u64,
    sessions: SenderTracker,
    plan: Option<(u64, u64)>,
    next: u64,
    stream: Digest,
    stream_after_first: Digest,
    finished: bool,
    refusal: Option<Refusal>,
    margins: Margins,
    rest_state: RestState,
    walked: u64,
    corrections: heapless::Vec<WorldCorrection, CORRECTIONS_MAX>,
    busy: bool,
    stats: ReceiverStats,
}

impl StreamState {
    /// Before the first chunk.
    pub(crate) fn new(controller_id: u64) -> Self {
        Self {
            controller_id,
            sessions: SenderTracker::default(),
            plan: None,
            next: 0,
            stream: Digest::default(),
            stream_after_first: Digest::default(),
            finished: false,
            refusal: None,
            margins: Margins::UNMEASURED,
            rest_state: bytemuck::Zeroable::zeroed(),
            walked: 0,
            corrections: heapless::Vec::new(),
            busy: false,
            stats: ReceiverStats::default(),
        }
    }

    /// Where the controller before this one left the robot.
    pub(crate) fn take_over(controller_id: u64, record: &JournalRecord) -> Self {
        let feedback = &record.feedback;
        let mut sessions = SenderTracker::default();
        if feedback.session != 0 {
            sessions.adopt(feedback.session);
        }
        let refused = feedback.verdict == Verdict::Refused as u32;
        let refusal = Check::from_wire(feedback.check).filter(|_| refused);
        Self {
            controller_id,
            sessions,
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
            rest_state: feedback.rest_state,
            walked: feedback.walked,
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
        self.stream_after_first
    }

    /// Decides what to do with a chunk, counts it, and moves to a new planner session or plan where
    /// it begins one.
    pub(crate) fn triage(&mut self, chunk: &PlanChunk) -> ChunkTriage {
        self.stats.received += 1;
        if !chunk.crc_matches() {
            return if self.refusal.is_some() {
                ChunkTriage::Ignore
            } else {
                ChunkTriage::Refuse(Check::Crc)
            };
        }
        if chunk.target_controller != self.controller_id {
            self.stats.foreign += 1;
            return ChunkTriage::Ignore;
        }
        match self.sessions.status(chunk.session) {
            SenderStatus::Stale => return self.ignore_stale(),
            SenderStatus::New if self.begins_other_stream(chunk) => self.begin_plan(chunk),
            SenderStatus::New if self.is_of_plan(chunk) => self.sessions.adopt(chunk.session),
            SenderStatus::New => return self.ignore_gap(),
            SenderStatus::Current if self.is_of_plan(chunk) => {}
            SenderStatus::Current
                if chunk.sequence == 0 && Some((chunk.plan_id, chunk.epoch)) > self.plan =>
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
        self.stream = stream;
        if self.next == 0 {
            self.stream_after_first = self.stream;
        }
        self.next += 1;
        self.finished = chunk.flags & FLAG_LAST != 0;
        self.margins = self.margins.min(margins);
        let last = executed.waypoints().last().unwrap_or(&self.rest_state.waypoint);
        self.rest_state = self.rest_state.after(executed.mode, executed.contacts(), last);
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
        self.refusal = Some(Refusal { sequence: self.next, check, waypoint });
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
        self.refusal
    }

    /// Whether the plan's last chunk is accepted.
    pub(crate) fn is_finished(&self) -> bool {
        self.finished
    }

    /// Whether a plan has begun and is neither finished nor refused.
    pub(crate) fn is_mid_plan(&self) -> bool {
        self.next > 0 && !self.finished && self.refusal.is_none()
    }

    /// Counters of the received chunks.
    pub(crate) fn stats(&self) -> ReceiverStats {
        self.stats
    }

    /// The `count`th feedback to the planner.
    pub(crate) fn feedback(&self, count: u64) -> Feedback {
        let (plan_id, epoch) = self.plan.unwrap_or_default();
        let verdict = match (self.refusal, self.next) {
            (Some(_), _) => Verdict::Refused,
            (None, 0) => Verdict::Waiting,
            (None, _) => Verdict::Accepted,
        };
        let mut corrections = [bytemuck::Zeroable::zeroed(); CORRECTIONS_MAX];
        corrections[..self.corrections.len()].copy_from_slice(&self.corrections);
        let mut feedback = Feedback {
            schema: FEEDBACK_SCHEMA,
            controller_id: self.controller_id,
            session: self.sessions.current().unwrap_or(0),
            plan_id,
            epoch,
            next_sequence: self.next,
            count,
            verdict: verdict as u32,
            check: self.refusal.map_or(0, |refusal| refusal.check as u32),
            refused_sequence: self.refusal.map_or(0, |refusal| refusal.sequence),
            refused_waypoint: self.refusal.map_or(0, |refusal| refusal.waypoint),
            finished: u32::from(self.finished),
            duplicated: self.stats.duplicates,
            gaps: self.stats.gaps,
            walked: self.walked,
            busy: u32::from(self.busy),
            corrections_len: self.corrections.len() as u32,
            reserved: 0,
            crc: 0,
            stream: self.stream,
            margins: self.margins,
            rest_state: self.rest_state,
            corrections,
        };
        feedback.write_crc();
        feedback
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

    fn begin_plan(&mut self, chunk: &PlanChunk) {
        self.sessions.adopt(chunk.session);
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next = 0;
        self.finished = false;
        self.refusal = None;
        self.margins = Margins::UNMEASURED;
    }

    fn triage_sequence(&mut self, chunk: &PlanChunk) -> ChunkTriage {
        if chunk.sequence < self.next {
            self.stats.duplicates += 1;
            return ChunkTriage::Ignore;
        }
        if chunk.sequence > self.next || self.finished {
            return self.ignore_gap();
        }
        if self.refusal.is_some() {
            return ChunkTriage::Ignore;
        }
        let continues = self.next == 0 || chunk.stream == self.stream;
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
