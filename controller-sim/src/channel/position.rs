//! Where the receiver stands in the stream, and what it makes of a chunk before anybody judges its
//! content.
//!
//! The CRC comes first: until it holds no field is believed. Then a chunk is for this controller
//! instance, of the planner session that speaks now, of the plan being walked, and the next one, or
//! it is not judged.

use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::instance::{Rank, Succession};
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::limits::CORRECTIONS_MAX;
use surefoot_shared_types::message::{
    Check, Correction, Feedback, Margins, PlanChunk, RobotRecord, Sealed, Standing, Verdict,
};

use super::{Refusal, Tally};

/// What to do with a received chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Admission {
    /// It is the next one: judge its content.
    Judge,
    /// It is damaged or does not continue the stream: refuse it for this reason.
    Refuse(Check),
    /// Not for now: a duplicate, a gap, a leftover, somebody else's, or anything after a refusal.
    Ignore,
}

/// The receiver's place in the stream.
#[derive(Debug)]
pub(super) struct Position {
    instance: u64,
    sessions: Succession,
    plan: Option<(u64, u64)>,
    next: u64,
    stream: Digest,
    stream_after_first: Digest,
    finished: bool,
    refusal: Option<Refusal>,
    margins: Margins,
    standing: Standing,
    walked: u64,
    corrections: heapless::Vec<Correction, CORRECTIONS_MAX>,
    busy: bool,
    tally: Tally,
}

impl Position {
    /// Before the first chunk.
    pub(super) fn new(instance: u64) -> Self {
        Self {
            instance,
            sessions: Succession::default(),
            plan: None,
            next: 0,
            stream: Digest::default(),
            stream_after_first: Digest::default(),
            finished: false,
            refusal: None,
            margins: Margins::UNMEASURED,
            standing: bytemuck::Zeroable::zeroed(),
            walked: 0,
            corrections: heapless::Vec::new(),
            busy: false,
            tally: Tally::default(),
        }
    }

    /// Where the controller before this one left the robot.
    pub(super) fn take_over(instance: u64, record: &RobotRecord) -> Self {
        let word = &record.word;
        let mut sessions = Succession::default();
        if word.session != 0 {
            sessions.enthrone(word.session);
        }
        let refused = word.verdict == Verdict::Refused as u32;
        let refusal = Check::from_wire(word.check).filter(|_| refused);
        Self {
            instance,
            sessions,
            plan: (word.session != 0).then_some((word.plan_id, word.epoch)),
            next: word.next_sequence,
            stream: word.stream,
            stream_after_first: record.stream_after_first,
            finished: word.finished != 0,
            refusal: refusal.map(|check| Refusal {
                sequence: word.refused_sequence,
                check,
                waypoint: word.refused_waypoint,
            }),
            margins: word.margins,
            standing: word.standing,
            walked: word.walked,
            corrections: word.corrections().iter().copied().collect(),
            busy: false,
            tally: Tally {
                accepted: word.next_sequence,
                duplicates: word.duplicated,
                gaps: word.gaps,
                ..Tally::default()
            },
        }
    }

    /// Digest of the stream after its first chunk, by which a successor of the planner is known.
    pub(super) fn stream_after_first(&self) -> Digest {
        self.stream_after_first
    }

    /// Decides what to do with a chunk, counts it, and moves to a new planner session or plan where
    /// it begins one.
    pub(super) fn admit(&mut self, chunk: &PlanChunk) -> Admission {
        self.tally.received += 1;
        if !chunk.is_intact() {
            return if self.refusal.is_some() {
                Admission::Ignore
            } else {
                Admission::Refuse(Check::Crc)
            };
        }
        if chunk.target_instance != self.instance {
            self.tally.foreign += 1;
            return Admission::Ignore;
        }
        match self.sessions.rank(chunk.session) {
            Rank::Replaced => return self.ignore_leftover(),
            Rank::New if self.begins_other_stream(chunk) => self.begin(chunk),
            Rank::New if self.is_of_plan(chunk) => self.sessions.enthrone(chunk.session),
            Rank::New => return self.ignore_gap(),
            Rank::Current if self.is_of_plan(chunk) => {}
            Rank::Current
                if chunk.sequence == 0 && Some((chunk.plan_id, chunk.epoch)) > self.plan =>
            {
                self.begin(chunk)
            }
            Rank::Current => return self.ignore_leftover(),
        }
        self.place(chunk)
    }

    /// The judged chunk is accepted, with which the stream has digest `stream`; `walked` is how the
    /// robot walked it.
    pub(super) fn accept(
        &mut self,
        chunk: &PlanChunk,
        stream: Digest,
        margins: &Margins,
        walked: &PlanChunk,
    ) {
        self.stream = stream;
        if self.next == 0 {
            self.stream_after_first = self.stream;
        }
        self.next += 1;
        self.finished = chunk.flags & FLAG_LAST != 0;
        self.margins = self.margins.min(margins);
        let last = walked.waypoints().last().unwrap_or(&self.standing.waypoint);
        self.standing = self.standing.after(walked.mode, walked.contacts(), last);
        self.walked += 1;
        self.tally.accepted += 1;
    }

    /// The chunk at the current place is refused; nothing of this stream is judged any more. A
    /// correction beyond [`CORRECTIONS_MAX`] is not told: then the refusal stands without one.
    pub(super) fn refuse(&mut self, check: Check, waypoint: u32, correction: Option<Correction>) {
        self.refusal = Some(Refusal { sequence: self.next, check, waypoint });
        if let Some(correction) = correction {
            let _ = self.corrections.push(correction);
        }
    }

    /// Whether a chunk is being judged now.
    pub(super) fn set_busy(&mut self, busy: bool) {
        self.busy = busy;
    }

    /// The refusal that holds, if any.
    pub(super) fn refusal(&self) -> Option<Refusal> {
        self.refusal
    }

    /// Whether the plan's last chunk is accepted.
    pub(super) fn is_finished(&self) -> bool {
        self.finished
    }

    /// Whether a plan has begun and is neither finished nor refused.
    pub(super) fn is_mid_plan(&self) -> bool {
        self.next > 0 && !self.finished && self.refusal.is_none()
    }

    /// What was received so far.
    pub(super) fn tally(&self) -> Tally {
        self.tally
    }

    /// The `count`th word to the planner.
    pub(super) fn feedback(&self, count: u64) -> Feedback {
        let (plan_id, epoch) = self.plan.unwrap_or_default();
        let verdict = match (self.refusal, self.next) {
            (Some(_), _) => Verdict::Refused,
            (None, 0) => Verdict::Waiting,
            (None, _) => Verdict::Accepted,
        };
        let mut corrections = [bytemuck::Zeroable::zeroed(); CORRECTIONS_MAX];
        corrections[..self.corrections.len()].copy_from_slice(&self.corrections);
        let mut word = Feedback {
            schema: FEEDBACK_SCHEMA,
            instance: self.instance,
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
            duplicated: self.tally.duplicates,
            gaps: self.tally.gaps,
            walked: self.walked,
            busy: u32::from(self.busy),
            corrections_len: self.corrections.len() as u32,
            reserved: 0,
            crc: 0,
            stream: self.stream,
            margins: self.margins,
            standing: self.standing,
            corrections,
        };
        word.seal();
        word
    }

    fn is_of_plan(&self, chunk: &PlanChunk) -> bool {
        self.plan == Some((chunk.plan_id, chunk.epoch))
    }

    /// Whether a chunk of a new session begins a stream other than the one being walked. A planner
    /// that was killed and planned the same again does not.
    fn begins_other_stream(&self, chunk: &PlanChunk) -> bool {
        let repeats_ours = self.is_of_plan(chunk)
            && self.next > 0
            && chunk.stream_after() == self.stream_after_first;
        chunk.sequence == 0 && !repeats_ours
    }

    fn begin(&mut self, chunk: &PlanChunk) {
        self.sessions.enthrone(chunk.session);
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next = 0;
        self.finished = false;
        self.refusal = None;
        self.margins = Margins::UNMEASURED;
    }

    fn place(&mut self, chunk: &PlanChunk) -> Admission {
        if chunk.sequence < self.next {
            self.tally.duplicates += 1;
            return Admission::Ignore;
        }
        if chunk.sequence > self.next || self.finished {
            return self.ignore_gap();
        }
        if self.refusal.is_some() {
            return Admission::Ignore;
        }
        let continues = self.next == 0 || chunk.stream == self.stream;
        if continues { Admission::Judge } else { Admission::Refuse(Check::Stream) }
    }

    fn ignore_gap(&mut self) -> Admission {
        self.tally.gaps += 1;
        Admission::Ignore
    }

    fn ignore_leftover(&mut self) -> Admission {
        self.tally.leftovers += 1;
        Admission::Ignore
    }
}

#[cfg(test)]
mod tests;
