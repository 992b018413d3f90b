//! The plan publisher: delivers the chunks of a plan to the controller, even if processes are
//! killed or stopped meanwhile.
//!
//! A chunk is delivered once a controller acknowledges it. The return value of iceoryx2's `send`
//! does not count, because other readers may listen. `send_window` holds the protocol, this file
//! adds shared memory and the clock.

use std::fs::File;
use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::loan_pool::LoanPool;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::role_lock;
use surefoot_shared_types::instance::role_publisher::{
    PublisherRole, Received, RolePublisher, name_publisher,
};
use surefoot_shared_types::instance::tuning::{
    CHUNK_POOL, LOANS_AHEAD, PEER_POLLING_TIME, WINDOW_CHUNKS,
};
use surefoot_shared_types::instance::wake_pipe::keep_polling;
use surefoot_shared_types::message::{Description, Feedback, PlanChunk, WithCrc};

pub use surefoot_shared_types::instance::error::ChannelError;

use crate::channel::chunk_source::{ChunkSource, CompletePlan, SourceState};
use crate::channel::send_window::{DeliveryOutcome, SendWindow};
use crate::channel::tuning::{
    CLEANUP_INTERVAL, FEEDBACK_PER_POLL_MAX, IDLE_HEARTBEATS, LOST_AFTER, NO_READER_MAX,
    POLL_GAP_MAX, RECONNECT_GO_BACKS, RECONNECT_INTERVAL, RESEND_AFTER, WAIT_MAX,
};

/// Result and statistics of a delivery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delivery {
    /// The result.
    pub outcome: DeliveryOutcome,
    /// Chunks sent, repetitions included.
    pub sent: u64,
    /// Chunks sent again: after a stall, or to a new controller.
    pub resent: u64,
    /// Chunks that the last controller accepted.
    pub accepted: u64,
    /// The last feedback, if any arrived.
    pub feedback: Option<Feedback>,
    /// Feedback messages of publishers other than the controller's, which were dropped: forged, or
    /// left over from a controller before.
    pub other_senders: u64,
    /// Time from the beginning of the delivery until the first chunk was sent, if one was.
    pub first_sent: Option<Duration>,
}

/// Sends chunks to the current controller of an instance.
pub struct PlanPublisher {
    loans: LoanPool<PlanChunk>,
    subscriber: Subscriber<ipc::Service, Feedback, ()>,
    participant: Participant,
    session: u64,
    lost_after: Duration,
    window_chunks: usize,
    /// Whose feedback counts.
    controller: RolePublisher,
    /// Feedback messages of other publishers, which were dropped.
    other_senders: u64,
    /// Held as long as this planner may send chunks.
    _lock: File,
}

/// A complete chunk in shared memory, to be sent once the window allows.
struct ReadyChunk {
    /// Its index in the stream, and the id of its controller.
    target: (usize, u64),
    sample: SampleMut<ipc::Service, PlanChunk, ()>,
}

/// State of a delivery between two polls.
struct DeliveryState {
    window: SendWindow,
    ready: Option<ReadyChunk>,
    last_feedback: Option<Feedback>,
    begin: DeliveryBegin,
    /// Time of the last poll.
    polled_at: Instant,
    /// Time without feedback, gaps between polls limited to [`POLL_GAP_MAX`].
    silence: Duration,
    /// Time of the last chunk or acknowledgement.
    active_at: Instant,
    progress_at: Instant,
    cleaned_up_at: Instant,
    /// Time since which the ports are as they are, and since which no reader took a chunk.
    ports: PortTimes,
    /// Whether this process slept since the last chunk; then the controller may sleep, too.
    has_slept: bool,
    /// Whether no reader took the last chunk. Then there is no controller, and the planner blocks
    /// before it sends again.
    has_no_reader: bool,
}

/// Times at which a delivery began, and at which its first chunk was sent.
struct DeliveryBegin {
    at: Instant,
    first_sent_at: Option<Instant>,
}

/// Times of the ports in a delivery.
struct PortTimes {
    /// Time at which they were made.
    made_at: Instant,
    /// Time since which no reader took a chunk, if it is so.
    unread_since: Option<Instant>,
}

impl PlanPublisher {
    /// Opens the chunk and feedback services of an instance as planner. `session` must not be 0 and
    /// must be unique among all planners (`instance::random_id`): it distinguishes the chunks of
    /// this process from those that a killed one left.
    ///
    /// # Errors
    /// [`ChannelError::Id`] if `session` is 0; [`ChannelError::PlannerTaken`] if another planner
    /// has opened them; other variants if a service has another message layout or the transport
    /// fails.
    pub fn open(instance: &Instance, session: u64) -> Result<Self, ChannelError> {
        if session == 0 {
            return Err(ChannelError::Id);
        }
        let lock = role_lock::acquire(instance, PublisherRole::Planner.file())?;
        let lock = lock.ok_or(ChannelError::PlannerTaken)?;
        let participant = Participant::open(instance)?;
        let making = participant.making()?;
        let loans = open_loans(&participant)?;
        let subscriber = open_subscriber(&participant)?;
        instance.reserve_segments()?;
        drop(making);
        Ok(Self {
            loans,
            subscriber,
            participant,
            session,
            lost_after: LOST_AFTER,
            window_chunks: WINDOW_CHUNKS,
            controller: RolePublisher::open(instance, PublisherRole::Controller)?,
            other_senders: 0,
            _lock: lock,
        })
    }

    /// Sets the number of chunks that may be in flight, 1 to [`WINDOW_CHUNKS`].
    pub fn set_window_chunks(&mut self, window_chunks: usize) {
        self.window_chunks = window_chunks.clamp(1, WINDOW_CHUNKS);
    }

    /// The session of this planner.
    pub fn session(&self) -> u64 {
        self.session
    }

    /// The controller's latest feedback, if any arrived since the last call.
    ///
    /// # Errors
    /// The transport fails.
    pub fn latest_feedback(&mut self) -> Result<Option<Feedback>, ChannelError> {
        let mut latest = None;
        for _ in 0..FEEDBACK_PER_POLL_MAX {
            match self.receive_one()? {
                Received::Nothing => break,
                Received::OfAnother => {}
                Received::Message(feedback) => {
                    latest = Some(*feedback).filter(Feedback::is_well_formed).or(latest);
                }
            }
        }
        Ok(latest)
    }

    /// Waits until the controller is idle, so that the robot stays in the rest state of its
    /// feedback. Returns that feedback; `None` if no feedback arrives for `longest` or `keep_going`
    /// returns `false`.
    ///
    /// # Errors
    /// The transport fails.
    pub fn wait_until_idle(
        &mut self,
        longest: Duration,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Feedback>, ChannelError> {
        let mut received_at = now();
        let mut idle: Option<(Feedback, u64)> = None;
        while keep_going() && received_at.elapsed() < longest {
            let Some(feedback) = self.latest_feedback()? else {
                self.participant.refresh_description();
                self.participant.feedback_wake_pipe.wait(WAIT_MAX);
                continue;
            };
            received_at = now();
            let idle_heartbeats = match &idle {
                Some((before, idle_heartbeats)) if is_idle_between(before, &feedback) => {
                    idle_heartbeats + 1
                }
                _ => 0,
            };
            if idle_heartbeats >= IDLE_HEARTBEATS {
                return Ok(Some(feedback));
            }
            idle = Some((feedback, idle_heartbeats));
        }
        Ok(None)
    }

    /// Publishes what readers have to know of this planner's walks.
    ///
    /// # Errors
    /// Shared memory is full, or the transport fails.
    pub fn describe(&mut self, description: &Description) -> Result<(), ChannelError> {
        self.participant.describe(description)
    }

    /// Whether a controller is connected. A killed one counts until a process cleans up,
    /// publishers of other processes do not.
    pub fn has_controller(&self) -> bool {
        self.controller.count(&self.participant.feedback) > 0
    }

    /// The participant of this process in the instance.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// Sets the time without feedback after which the controller counts as lost.
    pub fn set_lost_after(&mut self, lost_after: Duration) {
        self.lost_after = lost_after;
    }

    /// Delivers a complete stream of chunks in order. Only session, target controller and CRC are
    /// added to them. Returns once all are accepted, one is refused, no feedback arrives for too
    /// long, or `keep_going` returns `false`. `on_progress` receives every feedback of the current
    /// controller.
    ///
    /// # Errors
    /// [`ChannelError::Stream`] if the chunks are not one complete stream in order; other variants
    /// if the transport fails.
    pub fn deliver(
        &mut self,
        chunks: &[PlanChunk],
        on_progress: &mut dyn FnMut(&Feedback),
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Delivery, ChannelError> {
        self.deliver_from(&mut CompletePlan(chunks), on_progress, keep_going)
    }

    /// Like [`PlanPublisher::deliver`], of a plan that is made meanwhile: between two polls
    /// `source` makes chunks. Where it ends without a last chunk, those made are delivered all the
    /// same.
    ///
    /// # Errors
    /// As [`PlanPublisher::deliver`].
    pub fn deliver_from(
        &mut self,
        source: &mut dyn ChunkSource,
        on_progress: &mut dyn FnMut(&Feedback),
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Delivery, ChannelError> {
        self.loans.refill(LOANS_AHEAD)?;
        let mut state = DeliveryState::new(SendWindow::new(self.session, self.window_chunks));
        loop {
            state.window.extend(source.chunks(), source.state())?;
            self.receive_feedback(&mut state, on_progress)?;
            let outcome = state.window.outcome(state.age());
            let outcome = outcome.or_else(|| self.abort_outcome(&state, keep_going));
            if let Some(outcome) = outcome {
                let other_senders = std::mem::take(&mut self.other_senders);
                return Ok(state.delivery(outcome, other_senders));
            }
            if state.progress_at.elapsed() > RESEND_AFTER && state.window.go_back() {
                state.progress_at = now();
            }
            let sent = self.send_open_window(&mut state, source.chunks())?;
            self.clean_up_if_silent(&mut state);
            self.reconnect_if_stalled(&mut state)?;
            if sent == 0 && !self.prepare(&mut state, source.chunks())? {
                match source.state() {
                    SourceState::Open => source.advance(),
                    _ => self.sleep_if_idle(&mut state)?,
                }
            }
        }
    }

    /// Receives one message of feedback; those of publishers other than the controller's are
    /// dropped and counted, whatever they contain.
    fn receive_one(&mut self) -> Result<Received<Feedback>, ChannelError> {
        let received = self.controller.receive(&self.subscriber, "receiving feedback")?;
        self.other_senders += u64::from(matches!(received, Received::OfAnother));
        Ok(received)
    }

    /// Evaluates the feedback that has arrived.
    fn receive_feedback(
        &mut self,
        state: &mut DeliveryState,
        on_progress: &mut dyn FnMut(&Feedback),
    ) -> Result<(), ChannelError> {
        state.add_silence();
        for _ in 0..FEEDBACK_PER_POLL_MAX {
            let sample = match self.receive_one()? {
                Received::Nothing => break,
                Received::OfAnother => continue,
                Received::Message(sample) => sample,
            };
            let feedback = sample.payload();
            let acknowledged = state.window.acknowledged();
            if !state.window.receive(feedback, state.age(), state.silence) {
                continue;
            }
            state.silence = Duration::ZERO;
            if state.window.acknowledged() != acknowledged {
                state.progress_at = state.polled_at;
                state.active_at = state.polled_at;
            }
            state.last_feedback = Some(*feedback);
            on_progress(feedback);
        }
        Ok(())
    }

    /// Writes the next chunk into shared memory, if it is not there yet. Returns whether it did.
    fn prepare(
        &mut self,
        state: &mut DeliveryState,
        chunks: &[PlanChunk],
    ) -> Result<bool, ChannelError> {
        let next = state
            .window
            .next_chunk()
            .filter(|_| !state.has_no_reader)
            .filter(|next| state.ready.as_ref().is_none_or(|ready| ready.target != *next));
        if let Some(next) = next {
            state.ready = Some(self.write_ready(&chunks[next.0], next)?);
        }
        Ok(next.is_some())
    }

    /// Polls again soon after activity; later refills the loan pool and waits for the wake pipe.
    fn sleep_if_idle(&mut self, state: &mut DeliveryState) -> Result<(), ChannelError> {
        let has_no_reader = std::mem::take(&mut state.has_no_reader);
        if !has_no_reader && keep_polling(state.polled_at.duration_since(state.active_at)) {
            return Ok(());
        }
        self.loans.refill(LOANS_AHEAD)?;
        state.has_slept = true;
        self.participant.refresh_description();
        self.participant.feedback_wake_pipe.wait(WAIT_MAX);
        Ok(())
    }

    /// The outcome if the caller or the silence of the controller ends the delivery.
    fn abort_outcome(
        &self,
        state: &DeliveryState,
        keep_going: &dyn Fn() -> bool,
    ) -> Option<DeliveryOutcome> {
        if !keep_going() {
            return Some(DeliveryOutcome::Stopped);
        }
        (state.silence > self.lost_after).then_some(DeliveryOutcome::ControllerLost)
    }

    /// Sends the chunks that the window allows, until no reader receives one. Returns their number.
    fn send_open_window(
        &mut self,
        state: &mut DeliveryState,
        chunks: &[PlanChunk],
    ) -> Result<usize, ChannelError> {
        let mut sent = 0;
        while let Some(target) = state.window.to_send() {
            let ready = match state.ready.take().filter(|ready| ready.target == target) {
                Some(ready) => ready,
                None => self.write_ready(&chunks[target.0], target)?,
            };
            if send(ready)? == 0 {
                state.has_no_reader = true;
                state.ports.unread_since.get_or_insert(state.polled_at);
                break;
            }
            state.ports.unread_since = None;
            state.window.record_sent();
            state.begin.first_sent_at.get_or_insert_with(now);
            sent += 1;
        }
        if sent > 0 {
            let may_sleep = std::mem::take(&mut state.has_slept)
                || state.progress_at.elapsed() > PEER_POLLING_TIME;
            state.progress_at = now();
            state.active_at = state.progress_at;
            if may_sleep {
                self.participant.chunk_wake_pipe.notify();
            }
        }
        Ok(sent)
    }

    /// Writes a chunk into a loaned sample and completes it there.
    fn write_ready(
        &mut self,
        chunk: &PlanChunk,
        target: (usize, u64),
    ) -> Result<ReadyChunk, ChannelError> {
        let mut sample = self.loans.take()?;
        let chunk = sample.payload_mut().write(*chunk);
        (chunk.session, chunk.target_controller) = (self.session, target.1);
        chunk.write_crc();
        // SAFETY: `write` above initialised the payload.
        Ok(ReadyChunk { target, sample: unsafe { sample.assume_init() } })
    }

    /// Makes the ports anew where messages do not arrive: iceoryx2 does not repeat a connection
    /// that failed, for example because a process was killed at that moment.
    fn reconnect_if_stalled(&mut self, state: &mut DeliveryState) -> Result<(), ChannelError> {
        let is_unread = state.unread_for().is_some_and(|time| time > RECONNECT_INTERVAL);
        let is_stalled = state.silence > RECONNECT_INTERVAL
            || is_unread
            || state.window.go_backs() >= RECONNECT_GO_BACKS;
        if !is_stalled || state.ports.made_at.elapsed() < RECONNECT_INTERVAL {
            return Ok(());
        }
        if state.unread_for().is_some_and(|time| time > NO_READER_MAX)
            && state.silence < RECONNECT_INTERVAL
        {
            let reason = "the controller publishes feedback but takes no chunk";
            return Err(ChannelError::transport("sending a chunk", reason));
        }
        state.ports.made_at = state.polled_at;
        if !self.has_controller() {
            return Ok(());
        }
        let Some(making) = self.participant.try_making()? else { return Ok(()) };
        state.ready = None;
        self.subscriber = open_subscriber(&self.participant)?;
        self.loans = open_loans(&self.participant)?;
        drop(making);
        state.window.restart();
        Ok(())
    }

    /// Frees the resources of dead processes, so that a restarted controller can connect.
    fn clean_up_if_silent(&self, state: &mut DeliveryState) {
        if state.silence > CLEANUP_INTERVAL && state.cleaned_up_at.elapsed() > CLEANUP_INTERVAL {
            self.participant.clean_up_dead();
            state.cleaned_up_at = now();
        }
    }
}

impl DeliveryState {
    fn new(window: SendWindow) -> Self {
        let start = now();
        let (polled_at, active_at, progress_at, cleaned_up_at) = (start, start, start, start);
        let silence = Duration::ZERO;
        Self {
            window,
            ready: None,
            last_feedback: None,
            begin: DeliveryBegin { at: start, first_sent_at: None },
            polled_at,
            silence,
            active_at,
            progress_at,
            cleaned_up_at,
            ports: PortTimes { made_at: start, unread_since: None },
            has_slept: true,
            has_no_reader: false,
        }
    }

    /// Adds the time since the last poll to the silence of the controller.
    fn add_silence(&mut self) {
        let polled_at = now();
        self.silence += polled_at.duration_since(self.polled_at).min(POLL_GAP_MAX);
        self.polled_at = polled_at;
    }

    /// Time from the delivery's beginning to the last poll.
    fn age(&self) -> Duration {
        self.polled_at.duration_since(self.begin.at)
    }

    /// Time for which no reader took a chunk, if it is so.
    fn unread_for(&self) -> Option<Duration> {
        self.ports.unread_since.map(|since| self.polled_at.duration_since(since))
    }

    fn delivery(&self, outcome: DeliveryOutcome, other_senders: u64) -> Delivery {
        let (sent, resent) = self.window.counts();
        Delivery {
            outcome,
            sent,
            resent,
            accepted: self.window.acknowledged() as u64,
            feedback: self.last_feedback,
            other_senders,
            first_sent: self.begin.first_sent_at.map(|at| at.duration_since(self.begin.at)),
        }
    }
}

/// The publisher of chunks with its pool of loans, named as the planner's. The caller holds the
/// lock `making`.
fn open_loans(participant: &Participant) -> Result<LoanPool<PlanChunk>, ChannelError> {
    let publisher = participant
        .chunks
        .publisher_builder()
        .max_loaned_samples(CHUNK_POOL)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|error| ChannelError::transport("creating the chunk publisher", error))?;
    participant.instance.reserve_segments()?;
    let loans = LoanPool::new(publisher, CHUNK_POOL, LOANS_AHEAD)?;
    name_publisher(&participant.instance, PublisherRole::Planner, loans.publisher_id())?;
    Ok(loans)
}

/// The subscriber of feedback. The caller holds the lock `making`.
fn open_subscriber(
    participant: &Participant,
) -> Result<Subscriber<ipc::Service, Feedback, ()>, ChannelError> {
    let created = participant.feedback.subscriber_builder().create();
    created.map_err(|error| ChannelError::transport("creating the feedback subscriber", error))
}

/// Sends a chunk. Returns the number of readers that received it.
fn send(ready: ReadyChunk) -> Result<usize, ChannelError> {
    match ready.sample.send() {
        Ok(readers) => Ok(readers),
        // A reader died or its buffer is full: the chunk is sent again after the stall.
        Err(
            SendError::UnableToDeliver
            | SendError::ConnectionCorrupted
            | SendError::ConnectionError(_),
        ) => Ok(0),
        Err(error) => Err(ChannelError::transport("sending a chunk", error)),
    }
}

/// Whether the controller was idle between two feedback messages, and its robot stood.
fn is_idle_between(before: &Feedback, after: &Feedback) -> bool {
    let position = |feedback: &Feedback| {
        (
            feedback.controller_id,
            feedback.plan_id,
            feedback.epoch,
            feedback.next_sequence,
            feedback.walked,
        )
    };
    let stands = after.busy == 0 && after.moving == 0;
    stands && after.count > before.count && position(before) == position(after)
}

#[allow(
    clippy::disallowed_methods,
    reason = "time decides when a chunk is sent again, never its content"
)]
fn now() -> Instant {
    Instant::now()
}
