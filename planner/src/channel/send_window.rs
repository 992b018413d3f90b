//! The sender's window: which chunk goes next, and what the controller's feedback mean for it. No
//! clock, no transport.
//!
//! At most a few chunks are on their way. Acknowledgements are cumulative; after a stall everything
//! not acknowledged goes again (go-back-N). A controller instance is believed to have accepted a
//! chunk only if the stream digest it reports is that of our plan up to there, so neither a
//! restarted planner nor a restarted controller can mistake another plan's progress for its own.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::{ChannelError, SenderStatus, SenderTracker};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, Verdict};

use crate::channel::plan_publisher::DeliveryOutcome;

/// Idle heartbeats without progress that prove a chunk lost: a controller sends them only when it
/// has nothing to read.
pub(crate) const IDLE_HEARTBEATS: u64 = 3;
/// Go-backs without progress after which the controller counts as lost: it speaks, but what we send
/// never arrives.
const GO_BACKS_MAX: u32 = 500;

/// The state of one delivery.
pub(crate) struct SendWindow<'a> {
    chunks: &'a [PlanChunk],
    session: u64,
    size: usize,
    controllers: SenderTracker,
    end: Digest,
    acknowledged: usize,
    next: usize,
    highest_sent: usize,
    idle_heartbeats: u64,
    last_count: u64,
    go_backs: u32,
    refusal: Option<DeliveryOutcome>,
    sent: u64,
    resent: u64,
}

impl<'a> SendWindow<'a> {
    /// A window for `size` chunks over a whole stream, of which nothing is known to have arrived.
    pub(crate) fn new(
        chunks: &'a [PlanChunk],
        session: u64,
        size: usize,
    ) -> Result<Self, ChannelError> {
        let end = check_stream(chunks)?;
        Ok(Self {
            chunks,
            session,
            size,
            controllers: SenderTracker::default(),
            end,
            acknowledged: 0,
            next: 0,
            highest_sent: 0,
            idle_heartbeats: 0,
            last_count: 0,
            go_backs: 0,
            refusal: None,
            sent: 0,
            resent: 0,
        })
    }

    /// Takes in a controller's feedback. False if it is malformed or a replaced controller's, and
    /// was ignored.
    pub(crate) fn receive(&mut self, feedback: &Feedback) -> bool {
        if !feedback.is_well_formed() {
            return false;
        }
        match self.controllers.status(feedback.controller_id) {
            SenderStatus::Stale => return false,
            SenderStatus::New => self.follow(feedback),
            SenderStatus::Current => {}
        }
        self.advance(self.acknowledged_in(feedback), feedback);
        self.refusal = self.refusal_in(feedback).or_else(|| self.supersession_in(feedback));
        true
    }

    /// The place of the chunk to send now and the controller it is for, if the window is open.
    pub(crate) fn to_send(&self) -> Option<(usize, u64)> {
        let is_open = self.refusal.is_none() && self.next < self.acknowledged + self.size;
        self.next_chunk().filter(|_| is_open)
    }

    /// The place of the chunk that goes next, be the window open or not, and the controller it is
    /// for.
    pub(crate) fn next_chunk(&self) -> Option<(usize, u64)> {
        let controller = self.controllers.current()?;
        (self.next < self.chunks.len()).then_some((self.next, controller))
    }

    /// The chunk at a place.
    pub(crate) fn chunk(&self, index: usize) -> &'a PlanChunk {
        &self.chunks[index]
    }

    /// Notes that the chunk of [`Self::to_send`] went out.
    pub(crate) fn note_sent(&mut self) {
        self.sent += 1;
        self.resent += u64::from(self.next < self.highest_sent);
        self.next += 1;
        self.highest_sent = self.highest_sent.max(self.next);
        self.idle_heartbeats = 0;
    }

    /// Goes back to the first chunk not acknowledged if the controller has nothing to read any
    /// more. Ask only after a while without progress.
    pub(crate) fn go_back(&mut self) -> bool {
        let lost = self.next > self.acknowledged && self.idle_heartbeats >= IDLE_HEARTBEATS;
        if lost {
            self.next = self.acknowledged;
            self.idle_heartbeats = 0;
            self.go_backs += 1;
        }
        lost
    }

    /// How the delivery ended, if it did.
    pub(crate) fn outcome(&self) -> Option<DeliveryOutcome> {
        if self.acknowledged == self.chunks.len() {
            return Some(DeliveryOutcome::Accepted);
        }
        self.refusal.or((self.go_backs >= GO_BACKS_MAX).then_some(DeliveryOutcome::ControllerLost))
    }

    /// Chunks accepted by the controller instance that is listening now.
    pub(crate) fn acknowledged(&self) -> usize {
        self.acknowledged
    }

    /// Chunks sent in all, and those of them that had been sent before.
    pub(crate) fn counts(&self) -> (u64, u64) {
        (self.sent, self.resent)
    }

    fn follow(&mut self, feedback: &Feedback) {
        self.controllers.adopt(feedback.controller_id);
        self.acknowledged = self.acknowledged_in(feedback);
        self.next = self.acknowledged;
        self.idle_heartbeats = 0;
        self.go_backs = 0;
        self.last_count = feedback.count;
    }

    fn advance(&mut self, acknowledged_in: usize, feedback: &Feedback) {
        if acknowledged_in > self.acknowledged {
            self.acknowledged = acknowledged_in;
            self.next = self.next.max(acknowledged_in);
            self.idle_heartbeats = 0;
            self.go_backs = 0;
        } else if feedback.count > self.last_count && feedback.busy == 0 {
            self.idle_heartbeats += 1;
        }
        self.last_count = feedback.count;
    }

    /// How many of our chunks the controller has accepted.
    fn acknowledged_in(&self, feedback: &Feedback) -> usize {
        let Ok(accepted) = usize::try_from(feedback.next_sequence) else { return 0 };
        let ours = self.is_our_plan(feedback)
            && accepted <= self.chunks.len()
            && feedback.stream == self.stream_at(accepted);
        if ours { accepted } else { 0 }
    }

    fn is_our_plan(&self, feedback: &Feedback) -> bool {
        self.chunks
            .first()
            .is_some_and(|chunk| (chunk.plan_id, chunk.epoch) == (feedback.plan_id, feedback.epoch))
    }

    fn stream_at(&self, accepted: usize) -> Digest {
        self.chunks.get(accepted).map_or(self.end, |chunk| chunk.stream)
    }

    /// A refusal that concerns this delivery: of our session, or of our stream, or of a message
    /// whose sender is unknown because it was damaged before any was accepted.
    fn refusal_in(&self, feedback: &Feedback) -> Option<DeliveryOutcome> {
        if Verdict::from_wire(feedback.verdict) != Some(Verdict::Refused) {
            return None;
        }
        let ours = feedback.session == self.session && self.is_our_plan(feedback);
        if !(ours || feedback.session == 0 || self.acknowledged_in(feedback) > 0) {
            return None;
        }
        Check::from_wire(feedback.check).map(|check| DeliveryOutcome::Refused {
            sequence: feedback.refused_sequence,
            check,
            waypoint: feedback.refused_waypoint,
        })
    }
}

impl SendWindow<'_> {
    /// Whether the controller walks a later epoch of this plan than ours: then ours is out of date.
    fn supersession_in(&self, feedback: &Feedback) -> Option<DeliveryOutcome> {
        let first = self.chunks.first()?;
        let overtaken = feedback.session != 0
            && feedback.plan_id == first.plan_id
            && feedback.epoch > first.epoch;
        overtaken.then_some(DeliveryOutcome::Superseded)
    }
}

/// Checks that the chunks are one stream from its start; returns the digest of the whole.
fn check_stream(chunks: &[PlanChunk]) -> Result<Digest, ChannelError> {
    let Some(first) = chunks.first() else { return Err(ChannelError::Stream { index: 0 }) };
    let mut stream = first.stream;
    for (index, chunk) in chunks.iter().enumerate() {
        let same_plan = (chunk.plan_id, chunk.epoch) == (first.plan_id, first.epoch);
        if !same_plan || chunk.sequence != index as u64 || chunk.stream != stream {
            return Err(ChannelError::Stream { index });
        }
        stream = chunk.stream_after();
    }
    Ok(stream)
}

#[cfg(test)]
mod tests;
