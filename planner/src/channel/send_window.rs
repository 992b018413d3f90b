//! The send window: the chunk to send next, and the effect of the controller's feedback on it,
//! without clock and transport. The stream may grow while its first chunks are sent.
//!
//! At most a few chunks are in flight. Acknowledgements are cumulative; after a stall all
//! unacknowledged chunks are sent again (go-back-N). An acknowledgement counts only if the stream
//! digest in the feedback is that of this plan up to the acknowledged chunk. So neither a restarted
//! planner nor a restarted controller takes the progress of another plan for its own.
//!
//! Another process may publish feedback in the controller's name. A controller repeats its feedback
//! every millisecond, so a claim that ends the delivery counts only once the controller has
//! repeated it, or is silent. Where contradictions go on, they end the delivery.

use std::time::Duration;

use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::sender::{SenderStatus, SenderTracker};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, Verdict};

use crate::channel::chunk_source::SourceState;
use crate::channel::stream_outline::StreamOutline;
use crate::channel::tuning::{
    CONFIRM_TIME, CONFIRMATIONS, CONTRADICTIONS_MAX, GO_BACKS_MAX, HORIZON_SECONDS,
    IDLE_HEARTBEATS, LOWER_ACKNOWLEDGEMENTS, TAKEOVER_SILENCE,
};

/// Result of a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryOutcome {
    /// The controller accepted every chunk of a complete stream.
    Accepted,
    /// The controller accepted every chunk, but no chunk ends the stream: the robot
    /// stands where it stops in the last one.
    Incomplete,
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
    /// Two processes publish feedback as the controller.
    Contradicted,
    /// The caller stopped it.
    Stopped,
}

/// State of one delivery.
#[cfg_attr(test, derive(Clone))]
pub(crate) struct SendWindow {
    stream: StreamOutline,
    session: u64,
    /// Most chunks in flight.
    size: usize,
    controllers: SenderTracker,
    /// Whether the last feedback acknowledges chunks of this plan that are not made yet. A
    /// predecessor of this planner sent them; none is sent until they are made.
    is_behind: bool,
    progress: StreamProgress,
    stall: StallDetection,
    disputes: Disputes,
    /// The refusal or supersession in the last feedback.
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

/// Signs of a second process that publishes feedback as the controller.
#[derive(Debug, Clone, Copy, Default)]
struct Disputes {
    /// Time of the feedback that first made the present claim.
    claimed_at: Duration,
    /// Feedback messages that have repeated it.
    repetitions: u32,
    /// Consecutive feedback messages that acknowledge fewer chunks than one before.
    lower_acknowledgements: u32,
    /// Whether another controller published feedback after the current one.
    has_rival: bool,
    /// Number of contradictions so far.
    contradictions: u32,
}

impl SendWindow {
    /// A window of `size` chunks over a stream that has no chunks so far.
    pub(crate) fn new(session: u64, size: usize) -> Self {
        Self {
            stream: StreamOutline::default(),
            session,
            size,
            controllers: SenderTracker::default(),
            is_behind: false,
            progress: StreamProgress::default(),
            stall: StallDetection::default(),
            disputes: Disputes::default(),
            refusal: None,
            sent: 0,
            resent: 0,
        }
    }

    /// Takes the chunks made so far, and whether more are to follow.
    ///
    /// # Errors
    /// [`ChannelError::Stream`] if the chunks are not one stream in order.
    pub(crate) fn extend(
        &mut self,
        chunks: &[PlanChunk],
        state: SourceState,
    ) -> Result<(), ChannelError> {
        self.stream.extend(chunks, state)
    }

    /// Evaluates the feedback of a controller at the time `at` of the delivery, after `silence`
    /// without feedback of the current controller. Returns `false` if it is ignored because it is
    /// malformed, or the current controller is not silent and another one published it.
    pub(crate) fn receive(&mut self, feedback: &Feedback, at: Duration, silence: Duration) -> bool {
        if !feedback.is_well_formed() {
            return false;
        }
        let claim = self.claim();
        if self.controllers.status(feedback.controller_id) != SenderStatus::Current {
            if self.controllers.current().is_some() && silence < TAKEOVER_SILENCE {
                self.disputes.has_rival = true;
                return false;
            }
            self.follow(feedback);
        } else if std::mem::take(&mut self.disputes.has_rival) {
            self.disputes.contradictions += 1;
        }
        let is_new = feedback.count != self.stall.last_count;
        self.is_behind = self.acknowledges_more(feedback);
        self.advance(self.acknowledged_in(feedback), feedback);
        self.refusal = self.refusal_in(feedback).or_else(|| self.supersession_in(feedback));
        self.disputes.contradictions += u32::from(claim.is_some() && self.claim() != claim);
        if self.claim() != claim || self.disputes.lower_acknowledgements > 0 {
            (self.disputes.claimed_at, self.disputes.repetitions) = (at, 0);
        } else if is_new {
            self.disputes.repetitions = self.disputes.repetitions.saturating_add(1);
        }
        true
    }

    /// Index of the chunk to send now and its controller, if the window is open.
    pub(crate) fn to_send(&self) -> Option<(usize, u64)> {
        let StreamProgress { acknowledged, next, .. } = self.progress;
        let is_open = self.refusal.is_none() && !self.is_behind && next < acknowledged + self.size;
        self.next_chunk().filter(|_| is_open && self.is_within_horizon())
    }

    /// Whether the next chunk starts soon after the first one that is not acknowledged. Two chunks
    /// may always be in flight.
    fn is_within_horizon(&self) -> bool {
        let StreamProgress { acknowledged, next, .. } = self.progress;
        let start = |index: usize| self.stream.begins.get(index).map_or(0.0, |begin| begin.time);
        next < acknowledged + 2 || start(next) - start(acknowledged) < HORIZON_SECONDS
    }

    /// Index of the chunk to send next and its controller, whether the window is open or not.
    pub(crate) fn next_chunk(&self) -> Option<(usize, u64)> {
        let controller = self.controllers.current()?;
        (self.progress.next < self.stream.len()).then_some((self.progress.next, controller))
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

    /// The result of the delivery, once it has ended. `at` is the time of the delivery.
    pub(crate) fn outcome(&self, at: Duration) -> Option<DeliveryOutcome> {
        if self.disputes.contradictions >= CONTRADICTIONS_MAX {
            return Some(DeliveryOutcome::Contradicted);
        }
        let is_confirmed = self.disputes.repetitions >= CONFIRMATIONS
            || at.saturating_sub(self.disputes.claimed_at) >= CONFIRM_TIME;
        match self.claim() {
            Some(claim) => is_confirmed.then_some(claim),
            None => {
                (self.stall.go_backs >= GO_BACKS_MAX).then_some(DeliveryOutcome::ControllerLost)
            }
        }
    }

    /// The result that the last feedback claims.
    fn claim(&self) -> Option<DeliveryOutcome> {
        let is_over = self.progress.acknowledged == self.stream.len();
        match self.stream.state {
            SourceState::Complete if is_over => Some(DeliveryOutcome::Accepted),
            SourceState::Ended if is_over => Some(DeliveryOutcome::Incomplete),
            _ => self.refusal,
        }
    }

    /// Go-backs without progress.
    pub(crate) fn go_backs(&self) -> u32 {
        self.stall.go_backs
    }

    /// Sends all unacknowledged chunks again.
    pub(crate) fn restart(&mut self) {
        self.progress.next = self.progress.acknowledged;
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
        let acknowledged = self.acknowledged_in(feedback).unwrap_or(0);
        (self.progress.acknowledged, self.progress.next) = (acknowledged, acknowledged);
        self.disputes.lower_acknowledgements = 0;
        self.stall = StallDetection { last_count: feedback.count, ..StallDetection::default() };
    }

    /// Advances the window to an acknowledgement, or counts an idle heartbeat.
    fn advance(&mut self, acknowledged_in: Option<usize>, feedback: &Feedback) {
        let is_new = feedback.count != self.stall.last_count;
        match acknowledged_in {
            Some(accepted) if accepted > self.progress.acknowledged => {
                self.progress.acknowledged = accepted;
                self.progress.next = self.progress.next.max(accepted);
                self.stall.idle_heartbeats = 0;
                self.stall.go_backs = 0;
                self.disputes.lower_acknowledgements = 0;
            }
            Some(accepted) if accepted < self.progress.acknowledged => {
                self.disputes.lower_acknowledgements += u32::from(is_new);
                if self.disputes.lower_acknowledgements >= LOWER_ACKNOWLEDGEMENTS {
                    // The controller repeats it: the higher number was not the controller's.
                    (self.progress.acknowledged, self.progress.next) = (accepted, accepted);
                    self.disputes.lower_acknowledgements = 0;
                    self.disputes.contradictions += 1;
                }
            }
            _ => {
                self.disputes.lower_acknowledgements = 0;
                let is_idle = feedback.count > self.stall.last_count && feedback.busy == 0;
                self.stall.idle_heartbeats += u64::from(is_idle);
            }
        }
        self.stall.last_count = feedback.count;
    }

    /// Number of chunks of this stream that the controller has accepted; `None` if the feedback is
    /// about another stream.
    fn acknowledged_in(&self, feedback: &Feedback) -> Option<usize> {
        let accepted = usize::try_from(feedback.next_sequence).ok()?;
        let is_this_stream = self.is_this_plan(feedback)
            && accepted <= self.stream.len()
            && (accepted == 0 || feedback.stream == self.stream.digest_at(accepted));
        is_this_stream.then_some(accepted)
    }

    /// Whether the feedback acknowledges chunks of this plan that are not made yet.
    fn acknowledges_more(&self, feedback: &Feedback) -> bool {
        self.stream.state == SourceState::Open
            && self.is_this_plan(feedback)
            && feedback.next_sequence > self.stream.len() as u64
    }

    /// Whether the feedback is about this plan and epoch.
    fn is_this_plan(&self, feedback: &Feedback) -> bool {
        self.stream.name == Some((feedback.plan_id, feedback.epoch))
    }

    /// A refusal that concerns this delivery: of this session, of this stream, or of a damaged
    /// message of unknown sender.
    fn refusal_in(&self, feedback: &Feedback) -> Option<DeliveryOutcome> {
        if Verdict::from_wire(feedback.verdict) != Some(Verdict::Refused) {
            return None;
        }
        // The refused chunk follows the accepted ones, and these are ours.
        let acknowledged = self.acknowledged_in(feedback);
        let is_of_stream =
            feedback.refused_sequence == feedback.next_sequence && acknowledged.is_some();
        let is_addressed = feedback.session == self.session || acknowledged > Some(0);
        let concerns_this_plan = is_of_stream && is_addressed || feedback.session == 0;
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
        let (plan_id, epoch) = self.stream.name?;
        let is_superseded =
            feedback.session != 0 && feedback.plan_id == plan_id && feedback.epoch > epoch;
        is_superseded.then_some(DeliveryOutcome::Superseded)
    }
}

#[cfg(test)]
mod exploration;
#[cfg(test)]
mod tests;
