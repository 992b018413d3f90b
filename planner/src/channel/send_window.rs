//! The send window: the chunk to send next, and the effect of the controller's feedback on it,
//! without clock and transport.
//!
//! At most a few chunks are in flight. Acknowledgements are cumulative; after a stall all
//! unacknowledged chunks are sent again (go-back-N). An acknowledgement counts only if the stream
//! digest in the feedback is that of this plan up to the acknowledged chunk. So neither a restarted
//! planner nor a restarted controller takes the progress of another plan for its own.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::sender::{SenderStatus, SenderTracker};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, Verdict};

use crate::channel::tuning::{GO_BACKS_MAX, HORIZON_SECONDS, IDLE_HEARTBEATS};

/// Result of a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryOutcome {
    /// The controller accepted every chunk.
    Accepted,
    /// The controller refused a chunk and stops at the end of the one before.
    Refused {
        /// The refused chunk.
        sequence: u64,
        /// The check that it violates.
        check: Check,
        /// Index of the waypoint in the chunk.
        waypoint: u32,
    },
    /// The controller executes a later epoch of the same plan, from another planner.
    Superseded,
    /// No feedback arrived for too long, or the controller never received the chunks.
    ControllerLost,
    /// The caller stopped it.
    Stopped,
}

/// State of one delivery.
pub(crate) struct SendWindow<'a> {
    chunks: &'a [PlanChunk],
    session: u64,
    /// Most chunks in flight.
    size: usize,
    controllers: SenderTracker,
    /// Digest of the whole stream.
    end: Digest,
    progress: StreamProgress,
    stall: StallDetection,
    /// The refusal or supersession that ends the delivery.
    refusal: Option<DeliveryOutcome>,
    sent: u64,
    resent: u64,
}

/// Positions in the stream, as indices of chunks.
#[derive(Debug, Clone, Copy, Default)]
struct StreamProgress {
    /// Number of chunks that the current controller has acknowledged.
    acknowledged: usize,
    /// The chunk that is sent next.
    next: usize,
    /// One more than the highest index sent so far.
    highest_sent: usize,
}

/// Counters that detect lost chunks.
#[derive(Debug, Clone, Copy, Default)]
struct StallDetection {
    /// Consecutive idle heartbeats without progress.
    idle_heartbeats: u64,
    /// The count of the last feedback.
    last_count: u64,
    /// Go-backs without progress.
    go_backs: u32,
}

impl<'a> SendWindow<'a> {
    /// A window of `size` chunks over a whole stream, of which none is acknowledged.
    ///
    /// # Errors
    /// [`ChannelError::Stream`] if the chunks are not one complete stream in order.
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
            progress: StreamProgress::default(),
            stall: StallDetection::default(),
            refusal: None,
            sent: 0,
            resent: 0,
        })
    }

    /// Evaluates the feedback of a controller. Returns `false` if it is ignored because it is
    /// malformed or from a stale controller.
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

    /// Index of the chunk to send now and its controller, if the window is open.
    pub(crate) fn to_send(&self) -> Option<(usize, u64)> {
        let StreamProgress { acknowledged, next, .. } = self.progress;
        let is_open = self.refusal.is_none() && next < acknowledged + self.size;
        self.next_chunk().filter(|_| is_open && self.is_within_horizon())
    }

    /// Whether the next chunk starts soon after the first one that is not acknowledged. Two chunks
    /// may always be in flight.
    fn is_within_horizon(&self) -> bool {
        let StreamProgress { acknowledged, next, .. } = self.progress;
        let start =
            |index: usize| self.chunks.get(index).map_or(0.0, |chunk| chunk.waypoints[0].time);
        next < acknowledged + 2 || start(next) - start(acknowledged) < HORIZON_SECONDS
    }

    /// Index of the chunk to send next and its controller, whether the window is open or not.
    pub(crate) fn next_chunk(&self) -> Option<(usize, u64)> {
        let controller = self.controllers.current()?;
        (self.progress.next < self.chunks.len()).then_some((self.progress.next, controller))
    }

    /// The chunk of an index.
    pub(crate) fn chunk(&self, index: usize) -> &'a PlanChunk {
        &self.chunks[index]
    }

    /// Records that the chunk of [`Self::to_send`] was sent.
    pub(crate) fn record_sent(&mut self) {
        self.sent += 1;
        self.resent += u64::from(self.progress.next < self.progress.highest_sent);
        self.progress.next += 1;
        self.progress.highest_sent = self.progress.highest_sent.max(self.progress.next);
        self.stall.idle_heartbeats = 0;
    }

    /// Goes back to the first unacknowledged chunk if the controller is idle. Call it only after a
    /// time without progress. Returns whether it went back.
    pub(crate) fn go_back(&mut self) -> bool {
        let is_lost = self.progress.next > self.progress.acknowledged
            && self.stall.idle_heartbeats >= IDLE_HEARTBEATS;
        if is_lost {
            self.progress.next = self.progress.acknowledged;
            self.stall.idle_heartbeats = 0;
            self.stall.go_backs += 1;
        }
        is_lost
    }

    /// The result of the delivery, once it has ended.
    pub(crate) fn outcome(&self) -> Option<DeliveryOutcome> {
        if self.progress.acknowledged == self.chunks.len() {
            return Some(DeliveryOutcome::Accepted);
        }
        self.refusal
            .or((self.stall.go_backs >= GO_BACKS_MAX).then_some(DeliveryOutcome::ControllerLost))
    }

    /// Number of chunks that the current controller has accepted.
    pub(crate) fn acknowledged(&self) -> usize {
        self.progress.acknowledged
    }

    /// Number of chunks sent, and how many of them were sent before.
    pub(crate) fn counts(&self) -> (u64, u64) {
        (self.sent, self.resent)
    }

    /// Makes a new controller the current one.
    fn follow(&mut self, feedback: &Feedback) {
        self.controllers.adopt(feedback.controller_id);
        let acknowledged = self.acknowledged_in(feedback);
        (self.progress.acknowledged, self.progress.next) = (acknowledged, acknowledged);
        self.stall = StallDetection { last_count: feedback.count, ..StallDetection::default() };
    }

    /// Advances the window to an acknowledgement, or counts an idle heartbeat.
    fn advance(&mut self, acknowledged_in: usize, feedback: &Feedback) {
        if acknowledged_in > self.progress.acknowledged {
            self.progress.acknowledged = acknowledged_in;
            self.progress.next = self.progress.next.max(acknowledged_in);
            self.stall.idle_heartbeats = 0;
            self.stall.go_backs = 0;
        } else if feedback.count > self.stall.last_count && feedback.busy == 0 {
            self.stall.idle_heartbeats += 1;
        }
        self.stall.last_count = feedback.count;
    }

    /// Number of chunks of this stream that the controller has accepted.
    fn acknowledged_in(&self, feedback: &Feedback) -> usize {
        let Ok(accepted) = usize::try_from(feedback.next_sequence) else { return 0 };
        let is_this_stream = self.is_this_plan(feedback)
            && accepted <= self.chunks.len()
            && feedback.stream == self.stream_at(accepted);
        if is_this_stream { accepted } else { 0 }
    }

    /// Whether the feedback is about this plan and epoch.
    fn is_this_plan(&self, feedback: &Feedback) -> bool {
        self.chunks
            .first()
            .is_some_and(|chunk| (chunk.plan_id, chunk.epoch) == (feedback.plan_id, feedback.epoch))
    }

    /// The stream digest before the chunk of an index.
    fn stream_at(&self, accepted: usize) -> Digest {
        self.chunks.get(accepted).map_or(self.end, |chunk| chunk.stream)
    }

    /// A refusal that concerns this delivery: of this session, of this stream, or of a damaged
    /// message of unknown sender.
    fn refusal_in(&self, feedback: &Feedback) -> Option<DeliveryOutcome> {
        if Verdict::from_wire(feedback.verdict) != Some(Verdict::Refused) {
            return None;
        }
        let is_this_session = feedback.session == self.session && self.is_this_plan(feedback);
        let concerns_this_plan =
            is_this_session || feedback.session == 0 || self.acknowledged_in(feedback) > 0;
        if !(concerns_this_plan || self.is_correction_of_first_chunk(feedback)) {
            return None;
        }
        Check::from_wire(feedback.check).map(|check| DeliveryOutcome::Refused {
            sequence: feedback.refused_sequence,
            check,
            waypoint: feedback.refused_waypoint,
        })
    }

    /// Whether the controller refused the first chunk of this plan, from any session, and reports
    /// corrections. They hold for every plan, so a restarted planner plans again with them.
    fn is_correction_of_first_chunk(&self, feedback: &Feedback) -> bool {
        self.is_this_plan(feedback)
            && Check::from_wire(feedback.check) == Some(Check::WorldDiffers)
            && feedback.refused_sequence == 0
            && feedback.corrections_len > 0
    }

    /// Supersession, if the controller executes a later epoch of this plan.
    fn supersession_in(&self, feedback: &Feedback) -> Option<DeliveryOutcome> {
        let first = self.chunks.first()?;
        let is_superseded = feedback.session != 0
            && feedback.plan_id == first.plan_id
            && feedback.epoch > first.epoch;
        is_superseded.then_some(DeliveryOutcome::Superseded)
    }
}

/// Checks that the chunks are one complete stream. Returns the digest of the whole.
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
