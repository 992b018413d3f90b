//! The planner's end of the transport: delivers the chunks of a plan, whoever is killed or stopped
//! meanwhile.
//!
//! A chunk counts as delivered only when a controller acknowledges it; what iceoryx2's `send`
//! returns counts for nothing, because readers other than the controller may listen. The protocol
//! stands in `window`, this file adds shared memory and the clock.

use crate::channel::send_window;
use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;
use surefoot_shared_types::instance::Participant;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::loan_pool::LoanPool;
use surefoot_shared_types::instance::participant::{CHUNK_POOL, LOANS_AHEAD, WINDOW_CHUNKS};
use surefoot_shared_types::instance::wake_pipe::{PEER_POLLING_TIME, keep_polling};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, WithCrc};

pub use surefoot_shared_types::instance::ChannelError;

use crate::channel::send_window::SendWindow;

/// Time without progress after which chunks are sent again, if the controller has nothing to read.
const RESEND_AFTER: Duration = Duration::from_millis(20);
/// Time without feedback from any controller after which dead processes are cleaned away, and again
/// and again after it.
const CLEANUP_INTERVAL: Duration = Duration::from_millis(200);
/// Time without feedback from any controller after which it counts as lost, unless told otherwise.
const LOST_AFTER: Duration = Duration::from_secs(30);
/// How long the sender sleeps where no bell wakes it.
const SLEEP: Duration = Duration::from_millis(4);
/// The longest time between two looks that counts as silence of the controller: whoever was stopped
/// heard nothing.
const POLL_GAP_MAX: Duration = Duration::from_millis(100);

/// How a delivery ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryOutcome {
    /// The controller accepted every chunk.
    Accepted,
    /// The controller refused a chunk and stands at the end of the one before.
    Refused {
        /// The refused chunk.
        sequence: u64,
        /// What it violates.
        check: Check,
        /// Where in the chunk.
        waypoint: u32,
    },
    /// The controller walks a later epoch of the same plan: another planner planned again
    /// meanwhile.
    Superseded,
    /// No controller was heard for too long, or the one that was heard never received what was
    /// sent.
    ControllerLost,
    /// The caller ended it.
    Stopped,
}

/// What became of a plan's chunks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delivery {
    /// How it ended.
    pub outcome: DeliveryOutcome,
    /// Chunks put into shared memory, those sent again included.
    pub sent: u64,
    /// Chunks sent again: after a stall, or to a new controller instance.
    pub resent: u64,
    /// Chunks that the last controller instance accepted.
    pub accepted: u64,
    /// The controller's last feedback, if there was one.
    pub feedback: Option<Feedback>,
}

/// Sends chunks to whichever controller listens.
pub struct PlanPublisher {
    loans: LoanPool<PlanChunk>,
    subscriber: Subscriber<ipc::Service, Feedback, ()>,
    participant: Participant,
    session: u64,
    lost_after: Duration,
    window_chunks: usize,
}

/// A chunk that stands complete in shared memory before it may be sent.
struct ReadyChunk {
    /// Its place in the stream, and the controller it is for.
    target: (usize, u64),
    sample: SampleMut<ipc::Service, PlanChunk, ()>,
}

/// What a delivery remembers between two looks at the controller.
struct DeliveryState<'a> {
    window: SendWindow<'a>,
    ready: Option<ReadyChunk>,
    last_feedback: Option<Feedback>,
    polled_at: Instant,
    silence: Duration,
    active_at: Instant,
    progress_at: Instant,
    cleaned_up_at: Instant,
    /// Whether it slept since it last sent something: then nobody knows whether the controller did,
    /// too.
    has_slept: bool,
}

impl PlanPublisher {
    /// Enters the instance as a planner. `session` must not be 0 and must differ from that of every
    /// planner before (`instance::random_id`): it tells this process's chunks from a killed one's
    /// leftovers.
    ///
    /// # Errors
    /// `session` is 0, a service has another message layout, or the transport fails.
    pub fn open(instance: &Instance, session: u64) -> Result<Self, ChannelError> {
        if session == 0 {
            return Err(ChannelError::Id);
        }
        let participant = Participant::open(instance)?;
        let publisher = participant
            .chunks
            .publisher_builder()
            .max_loaned_samples(CHUNK_POOL)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| ChannelError::transport("creating the chunk publisher", error))?;
        let subscriber =
            participant.feedback.subscriber_builder().create().map_err(|error| {
                ChannelError::transport("creating the feedback subscriber", error)
            })?;
        instance.reserve_segments()?;
        let loans = LoanPool::new(publisher, CHUNK_POOL, LOANS_AHEAD)?;
        Ok(Self {
            loans,
            subscriber,
            participant,
            session,
            lost_after: LOST_AFTER,
            window_chunks: WINDOW_CHUNKS,
        })
    }

    /// Sets how many chunks may be on their way at a time, 1 to [`WINDOW_CHUNKS`].
    pub fn set_window_chunks(&mut self, window_chunks: usize) {
        self.window_chunks = window_chunks.clamp(1, WINDOW_CHUNKS);
    }

    /// This planner's session.
    pub fn session(&self) -> u64 {
        self.session
    }

    /// The latest feedback of whichever controller speaks, if one came since the last look.
    ///
    /// # Errors
    /// The transport fails.
    pub fn latest_feedback(&self) -> Result<Option<Feedback>, ChannelError> {
        let mut latest = None;
        while let Some(sample) = self
            .subscriber
            .receive()
            .map_err(|error| ChannelError::transport("receiving feedback", error))?
        {
            latest = Some(*sample.payload()).filter(Feedback::is_well_formed).or(latest);
        }
        Ok(latest)
    }

    /// Waits until the controller has nothing more to read, so that the robot stays where its
    /// feedback says; answers that feedback, or nothing where no controller speaks for `longest` or
    /// `keep_going` says no.
    ///
    /// # Errors
    /// The transport fails.
    pub fn wait_until_idle(
        &self,
        longest: Duration,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Feedback>, ChannelError> {
        let mut received_at = now();
        let mut idle: Option<(Feedback, u64)> = None;
        while keep_going() && received_at.elapsed() < longest {
            let Some(feedback) = self.latest_feedback()? else {
                self.participant.feedback_wake_pipe.wait(SLEEP);
                continue;
            };
            received_at = now();
            let quiet = match &idle {
                Some((before, quiet)) if is_idle_between(before, &feedback) => quiet + 1,
                _ => 0,
            };
            if quiet >= send_window::IDLE_HEARTBEATS {
                return Ok(Some(feedback));
            }
            idle = Some((feedback, quiet));
        }
        Ok(None)
    }

    /// The process's end of the instance.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// Sets how long no controller may be heard before it counts as lost.
    pub fn set_lost_after(&mut self, lost_after: Duration) {
        self.lost_after = lost_after;
    }

    /// Delivers a whole stream: complete chunks in order, to which only session, target instance
    /// and CRC are added. Returns when all are accepted, one is refused, no controller is heard for
    /// too long, or `keep_going` says no. `on_progress` gets every feedback of the listening
    /// controller.
    ///
    /// # Errors
    /// The chunks are not a complete stream in order, or the transport fails.
    pub fn deliver(
        &mut self,
        chunks: &[PlanChunk],
        on_progress: &mut dyn FnMut(&Feedback),
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Delivery, ChannelError> {
        self.loans.refill(LOANS_AHEAD)?;
        let mut state =
            DeliveryState::new(SendWindow::new(chunks, self.session, self.window_chunks)?);
        loop {
            self.receive_feedback(&mut state, on_progress)?;
            let outcome = state.window.outcome().or_else(|| self.abort_outcome(&state, keep_going));
            if let Some(outcome) = outcome {
                return Ok(state.delivery(outcome));
            }
            if state.progress_at.elapsed() > RESEND_AFTER && state.window.go_back() {
                state.progress_at = now();
            }
            let sent = self.send_open_window(&mut state)?;
            self.clean_up_if_silent(&mut state);
            if sent == 0 {
                self.prepare_or_sleep(&mut state)?;
            }
        }
    }

    fn receive_feedback(
        &self,
        state: &mut DeliveryState<'_>,
        on_progress: &mut dyn FnMut(&Feedback),
    ) -> Result<(), ChannelError> {
        state.add_silence();
        while let Some(sample) = self
            .subscriber
            .receive()
            .map_err(|error| ChannelError::transport("receiving feedback", error))?
        {
            let feedback = sample.payload();
            let acknowledged = state.window.acknowledged();
            if !state.window.receive(feedback) {
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

    /// Makes the chunk ready that goes next. Looks again at once after something happened; where
    /// nothing does, fills the stock and sleeps until the bell.
    fn prepare_or_sleep(&mut self, state: &mut DeliveryState<'_>) -> Result<(), ChannelError> {
        let next = state
            .window
            .next_chunk()
            .filter(|next| state.ready.as_ref().is_none_or(|ready| ready.target != *next));
        if let Some(next) = next {
            state.ready = Some(self.write_ready(state.window.chunk(next.0), next)?);
            return Ok(());
        }
        if keep_polling(state.polled_at.duration_since(state.active_at)) {
            return Ok(());
        }
        self.loans.refill(LOANS_AHEAD)?;
        state.has_slept = true;
        self.participant.feedback_wake_pipe.wait(SLEEP);
        Ok(())
    }

    fn abort_outcome(
        &self,
        state: &DeliveryState<'_>,
        keep_going: &dyn Fn() -> bool,
    ) -> Option<DeliveryOutcome> {
        if !keep_going() {
            return Some(DeliveryOutcome::Stopped);
        }
        (state.silence > self.lost_after).then_some(DeliveryOutcome::ControllerLost)
    }

    /// Sends what the window allows; stops early when no reader took a chunk.
    fn send_open_window(&mut self, state: &mut DeliveryState<'_>) -> Result<usize, ChannelError> {
        let mut sent = 0;
        while let Some(target) = state.window.to_send() {
            let ready = match state.ready.take().filter(|ready| ready.target == target) {
                Some(ready) => ready,
                None => self.write_ready(state.window.chunk(target.0), target)?,
            };
            if send(ready)? == 0 {
                break;
            }
            state.window.note_sent();
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

    /// Writes a chunk into shared memory that was loaned before and completes it there.
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

    /// Frees what dead processes hold, so that a restarted controller finds room.
    fn clean_up_if_silent(&self, state: &mut DeliveryState<'_>) {
        if state.silence > CLEANUP_INTERVAL && state.cleaned_up_at.elapsed() > CLEANUP_INTERVAL {
            self.participant.node.try_cleanup_dead_nodes();
            state.cleaned_up_at = now();
        }
    }
}

impl<'a> DeliveryState<'a> {
    fn new(window: SendWindow<'a>) -> Self {
        let start = now();
        let (polled_at, active_at, progress_at, cleaned_up_at) = (start, start, start, start);
        let silence = Duration::ZERO;
        Self {
            window,
            ready: None,
            last_feedback: None,
            polled_at,
            silence,
            active_at,
            progress_at,
            cleaned_up_at,
            has_slept: true,
        }
    }

    /// Adds the time since the last look to the controller's silence.
    fn add_silence(&mut self) {
        let look = now();
        self.silence += look.duration_since(self.polled_at).min(POLL_GAP_MAX);
        self.polled_at = look;
    }

    fn delivery(&self, outcome: DeliveryOutcome) -> Delivery {
        let (sent, resent) = self.window.counts();
        Delivery {
            outcome,
            sent,
            resent,
            accepted: self.window.acknowledged() as u64,
            feedback: self.last_feedback,
        }
    }
}

/// Sends a chunk that is ready. Returns how many readers took it.
fn send(ready: ReadyChunk) -> Result<usize, ChannelError> {
    match ready.sample.send() {
        Ok(readers) => Ok(readers),
        // A reader died or its buffer is full: the chunk goes again after the stall.
        Err(
            SendError::UnableToDeliver
            | SendError::ConnectionCorrupted
            | SendError::ConnectionError(_),
        ) => Ok(0),
        Err(error) => Err(ChannelError::transport("sending a chunk", error)),
    }
}

/// Whether a controller was idle between two of its feedback.
fn is_idle_between(before: &Feedback, after: &Feedback) -> bool {
    let place = |feedback: &Feedback| {
        (
            feedback.controller_id,
            feedback.plan_id,
            feedback.epoch,
            feedback.next_sequence,
            feedback.walked,
        )
    };
    after.busy == 0 && after.count > before.count && place(before) == place(after)
}

#[allow(
    clippy::disallowed_methods,
    reason = "time decides only when to send again, never what is sent"
)]
fn now() -> Instant {
    Instant::now()
}
