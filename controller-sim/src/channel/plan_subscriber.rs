//! The controller's end of the transport: receives chunks in order, once each, and publishes its
//! progress.
//!
//! A chunk is checked in shared memory, without a copy. `stream_state` decides which chunks are
//! checked; this file adds shared memory and the clock. Feedback is cumulative and repeated, so
//! that a planner that joins late, or missed a message, receives it. `journal` stores where the
//! robot stands for the controller that takes over when this one is killed.

use std::cell::Cell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::loan_pool::LoanPool;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::role_publisher::{
    PublisherRole, Received, RolePublisher, name_publisher,
};
use surefoot_shared_types::instance::tuning::{
    FEEDBACK_POOL, LOANS_AHEAD, PEER_POLLING_TIME, WINDOW_CHUNKS,
};
use surefoot_shared_types::instance::wake_pipe::{WakePipe, keep_polling};
use surefoot_shared_types::message::{
    Check, Description, Feedback, Margins, PlanChunk, WalkRecord, WorldCorrection,
};

pub use surefoot_shared_types::instance::error::ChannelError;

use crate::channel::fault_injection::FaultInjection;
use crate::channel::journal::{Journal, LastRecord};
use crate::channel::state_publisher::StatePublisher;
use crate::channel::stream_state::{
    ChunkTriage, ReceiverStats, Refusal, StreamState, WalkProgress,
};
use crate::channel::tuning::{CLEANUP_INTERVAL, HEARTBEAT_INTERVAL};
use crate::channel::walk_journal::WalkJournal;

/// Result of checking a chunk.
#[derive(Debug, Clone, PartialEq)]
pub enum ChunkDecision {
    /// Executed, with its worst margins and the digest of the stream with it
    /// ([`PlanChunk::stream_after`]), which the feedback carries.
    Accepted(Margins, Digest),
    /// As before, but executed as this chunk says, because the robot's feet are misplaced.
    AcceptedAs(Margins, Digest, Box<PlanChunk>),
    /// Not executed.
    Refused {
        /// The violated check.
        check: Check,
        /// The waypoint of the violation.
        waypoint: u32,
        /// With [`Check::WorldDiffers`], the difference. From the next epoch on the chunks must
        /// carry the digest of the world so corrected
        /// (`surefoot_shared_types::world::correction::corrected_digest`).
        correction: Option<WorldCorrection>,
    },
}

/// Checks chunks, each once and in order. While it works it may call `heartbeat` now and then, so
/// that the planner receives a heartbeat.
pub type ChunkCheck<'a> = dyn FnMut(&PlanChunk, &mut dyn FnMut()) -> ChunkDecision + 'a;

/// Checks chunks and walks them, each once and in order. Between the two the journal records the
/// decision, so that a robot never moves along a chunk that its next controller does not know.
pub trait ChunkExecution {
    /// Checks a chunk; see [`ChunkCheck`].
    fn check(&mut self, chunk: &PlanChunk, heartbeat: &mut dyn FnMut()) -> ChunkDecision;

    /// Walks an accepted chunk until the robot needs the next one, or holds the robot where one is
    /// refused. The planner receives the decision after that.
    fn execute(&mut self, chunk: &PlanChunk, decision: &ChunkDecision, heartbeat: &mut dyn FnMut());
}

/// Checks chunks for a robot that does not move.
struct CheckOnly<'a, 'b>(&'a mut ChunkCheck<'b>);

impl ChunkExecution for CheckOnly<'_, '_> {
    fn check(&mut self, chunk: &PlanChunk, heartbeat: &mut dyn FnMut()) -> ChunkDecision {
        (self.0)(chunk, heartbeat)
    }

    fn execute(&mut self, _: &PlanChunk, _: &ChunkDecision, _: &mut dyn FnMut()) {}
}

/// How receiving ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamEnd {
    /// The plan's last chunk is accepted.
    Finished,
    /// A chunk is refused; the robot stands at the end of the one before.
    Refused(Refusal),
    /// No planner is attached any more, and the plan is not finished; the robot stands at the end
    /// of the last executed chunk. Reported once until another chunk arrives.
    PlannerLeft,
    /// The caller ended it.
    Stopped,
}

/// Receives chunks and publishes feedback.
pub struct PlanSubscriber {
    subscriber: Subscriber<ipc::Service, PlanChunk, ()>,
    /// Whose chunks count.
    planner: RolePublisher,
    feedback_publisher: FeedbackPublisher,
    participant: Participant,
    stream_state: StreamState,
    journal: Journal,
    taken_over: Option<LastRecord>,
    active_at: Instant,
    cleaned_at: Instant,
    reported_left: bool,
    /// Whether it blocked since its last answer: the planner may have blocked too.
    has_slept: bool,
}

/// Publishes feedback.
struct FeedbackPublisher {
    loan_pool: LoanPool<Feedback>,
    /// What the robot does, which the feedback carries.
    walk: Rc<Cell<WalkProgress>>,
    count: u64,
    published_at: Instant,
    /// Time of the last answer to a chunk. Heartbeats do not wake the planner.
    answered_at: Instant,
    faults: Option<FaultInjection>,
}

impl PlanSubscriber {
    /// Joins the instance as a controller, where the one before left the robot. `id` must not be 0
    /// and must differ from that of every controller before (`instance::random_id`): chunks are
    /// addressed to it.
    ///
    /// # Errors
    /// `id` is 0, another controller moves the robot of this instance, the journal cannot be read
    /// or written, a service has another message layout, or the transport fails.
    pub fn open(instance: &Instance, id: u64) -> Result<Self, ChannelError> {
        if id == 0 {
            return Err(ChannelError::Id);
        }
        let participant = Participant::open(instance)?;
        let (journal, taken_over) = Journal::open(instance)?;
        let making = participant.making()?;
        let subscriber =
            participant.chunks.subscriber_builder().buffer_size(WINDOW_CHUNKS).create();
        let subscriber = subscriber
            .map_err(|error| ChannelError::transport("creating the chunk subscriber", error))?;
        let feedback_publisher = FeedbackPublisher::open(&participant)?;
        instance.reserve_segments()?;
        drop(making);
        let stream_state = taken_over.as_ref().map_or_else(
            || StreamState::new(id),
            |last| StreamState::take_over(id, &last.record, last.walk.as_ref()),
        );
        let start = now();
        let mut plan_subscriber = Self {
            subscriber,
            planner: RolePublisher::open(instance, PublisherRole::Planner)?,
            feedback_publisher,
            participant,
            stream_state,
            journal,
            taken_over,
            active_at: start,
            cleaned_at: start,
            reported_left: false,
            has_slept: true,
        };
        plan_subscriber.feedback_publisher.publish(&plan_subscriber.stream_state)?;
        Ok(plan_subscriber)
    }

    /// The publisher of the simulated robot's state.
    ///
    /// # Errors
    /// The transport fails.
    pub fn open_state(&self) -> Result<StatePublisher, ChannelError> {
        StatePublisher::open(&self.participant)
    }

    /// Publishes what readers have to know of this controller's walks.
    ///
    /// # Errors
    /// Shared memory is full, or the transport fails.
    pub fn describe(&mut self, description: &Description) -> Result<(), ChannelError> {
        self.participant.describe(description)
    }

    /// What the robot does, as the next feedback states it: to be kept up to date by the one who
    /// moves the robot.
    pub fn walk_progress(&self) -> Rc<Cell<WalkProgress>> {
        Rc::clone(&self.feedback_publisher.walk)
    }

    /// Loses and delays feedback messages, as the seed says. Any message may be lost, so the result
    /// must not change.
    pub fn inject_faults(&mut self, seed: u64) {
        self.feedback_publisher.faults = Some(FaultInjection::new(seed));
    }

    /// The last feedback of the controller whose robot this one took over, if there was one.
    pub fn taken_over(&self) -> Option<&Feedback> {
        self.taken_over.as_ref().map(|last| &last.record.feedback)
    }

    /// The last chunks of the plan in execution that the controller before accepted, in their
    /// order, and where in them it left the robot.
    pub fn chunks_taken_over(&self) -> (&[PlanChunk], Option<&WalkRecord>) {
        let last = self.taken_over.as_ref();
        last.map_or((&[], None), |last| (&last.chunks, last.walk.as_ref()))
    }

    /// The record of where the robot is: to be kept up to date by the one who moves the robot.
    ///
    /// # Errors
    /// The journal cannot be mapped.
    pub fn walk_journal(&self) -> Result<WalkJournal, ChannelError> {
        self.journal.walk_journal(self.chunks_taken_over().1)
    }

    /// Receives until the plan is finished, a chunk is refused, or `keep_going` returns false.
    /// `check_chunk` is called once per chunk, in order, after its CRC and its stream digest are
    /// checked, and `keep_going` between chunks, at least every few milliseconds. Call it again to
    /// wait for a new plan or epoch.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn run(
        &mut self,
        check_chunk: &mut ChunkCheck<'_>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<StreamEnd, ChannelError> {
        self.run_with(&mut CheckOnly(check_chunk), keep_going)
    }

    /// As [`Self::run`], for a robot that moves.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn run_with(
        &mut self,
        execution: &mut dyn ChunkExecution,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<StreamEnd, ChannelError> {
        while keep_going() {
            match self.receive_one(execution)? {
                Receipt::Nothing => {
                    self.idle()?;
                    if self.has_planner_left() {
                        return Ok(StreamEnd::PlannerLeft);
                    }
                }
                Receipt::Ignored => {
                    self.active_at = now();
                    self.publish_if_due()?;
                }
                Receipt::Checked => {
                    self.active_at = now();
                    self.reported_left = false;
                    if let Some(ended) = self.stream_end() {
                        return Ok(ended);
                    }
                }
            }
        }
        Ok(StreamEnd::Stopped)
    }

    /// How the stream ended at which the robot stands, if it did. A controller that takes over need
    /// not wait for a chunk then.
    pub fn stream_end(&self) -> Option<StreamEnd> {
        let refused = self.stream_state.refusal().map(StreamEnd::Refused);
        refused.or(self.stream_state.is_finished().then_some(StreamEnd::Finished))
    }

    /// Keeps running after a plan ends: repeats the last feedback until the planner has read it,
    /// and executes the next plan or epoch. Returns its end, or nothing once `keep_going` returns
    /// false. With a `timeout`, also nothing when no planner is attached or no plan has begun for
    /// that time.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn linger(
        &mut self,
        check_chunk: &mut ChunkCheck<'_>,
        timeout: Option<Duration>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<StreamEnd>, ChannelError> {
        self.linger_with(&mut CheckOnly(check_chunk), timeout, keep_going)
    }

    /// As [`Self::linger`], for a robot that moves.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn linger_with(
        &mut self,
        execution: &mut dyn ChunkExecution,
        timeout: Option<Duration>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<StreamEnd>, ChannelError> {
        let start = now();
        while keep_going() {
            if timeout.is_some_and(|timeout| start.elapsed() >= timeout || !self.has_planner()) {
                return Ok(None);
            }
            match self.receive_one(execution)? {
                Receipt::Checked if self.stream_end().is_some() => return Ok(self.stream_end()),
                Receipt::Checked => return self.run_with(execution, keep_going).map(Some),
                Receipt::Nothing | Receipt::Ignored => self.idle()?,
            }
        }
        Ok(None)
    }

    /// Whether the planner left in the middle of its plan and this is not reported yet.
    fn has_planner_left(&mut self) -> bool {
        let mid_plan = self.stream_state.is_mid_plan() && !self.reported_left;
        let left = mid_plan && !self.has_planner();
        self.reported_left |= left;
        left
    }

    /// Whether the planner is attached. A killed one counts until a process cleans up, publishers
    /// of other processes do not.
    fn has_planner(&self) -> bool {
        self.planner.count(&self.participant.chunks) > 0
    }

    /// Counters of the received chunks.
    pub fn stats(&self) -> ReceiverStats {
        self.stream_state.stats()
    }

    /// The current feedback.
    pub fn feedback(&self) -> Feedback {
        let publisher = &self.feedback_publisher;
        self.stream_state.feedback(publisher.count, publisher.walk.get())
    }

    /// Receives a chunk and answers it.
    fn receive_one(&mut self, execution: &mut dyn ChunkExecution) -> Result<Receipt, ChannelError> {
        let sample = match self.planner.receive(&self.subscriber, "receiving a chunk")? {
            Received::Nothing => return Ok(Receipt::Nothing),
            Received::OfAnother => {
                self.stream_state.ignore_other_sender();
                return Ok(Receipt::Ignored);
            }
            Received::Message(sample) => sample,
        };
        let chunk = sample.payload();
        match self.stream_state.triage(chunk) {
            ChunkTriage::Ignore => return Ok(Receipt::Ignored),
            ChunkTriage::Refuse(check) => {
                self.stream_state.refuse(check, 0, None);
                let walk = self.walk_progress();
                record(&mut self.journal, &self.stream_state, walk.get());
            }
            ChunkTriage::Check => self.check_and_execute(chunk, execution)?,
        }
        let feedback = self.feedback_publisher.next_feedback(&self.stream_state);
        let may_sleep = std::mem::take(&mut self.has_slept);
        self.feedback_publisher.publish_and_notify(
            feedback,
            may_sleep,
            &self.participant.feedback_wake_pipe,
        )?;
        Ok(Receipt::Checked)
    }

    /// Checks a chunk, records the decision and executes it, with heartbeats when that takes long.
    fn check_and_execute(
        &mut self,
        chunk: &PlanChunk,
        execution: &mut dyn ChunkExecution,
    ) -> Result<(), ChannelError> {
        let mut decided = self.stream_state.clone();
        self.stream_state.set_busy(true);
        let walk = self.walk_progress();
        let (feedback_publisher, stream_state) = (&mut self.feedback_publisher, &self.stream_state);
        let mut published = Ok(());
        let mut heartbeat = || {
            if published.is_ok() && feedback_publisher.is_due() {
                published = feedback_publisher.publish(stream_state);
            }
        };
        let decision = execution.check(chunk, &mut heartbeat);
        match &decision {
            ChunkDecision::Accepted(margins, stream) => {
                decided.accept(chunk, *stream, margins, chunk)
            }
            ChunkDecision::AcceptedAs(margins, stream, executed) => {
                decided.accept(chunk, *stream, margins, executed)
            }
            ChunkDecision::Refused { check, waypoint, correction } => {
                decided.refuse(*check, *waypoint, *correction)
            }
        }
        if !matches!(decision, ChunkDecision::Refused { .. }) {
            self.journal.store(decided.walked(), chunk);
        }
        record(&mut self.journal, &decided, walk.get());
        execution.execute(chunk, &decision, &mut heartbeat);
        self.stream_state = decided;
        published
    }

    /// Publishes a heartbeat if it is due. Called after every chunk that is not checked, so that
    /// no number of them delays one.
    fn publish_if_due(&mut self) -> Result<(), ChannelError> {
        if self.feedback_publisher.is_due() {
            self.feedback_publisher.publish(&self.stream_state)?;
        }
        Ok(())
    }

    /// Without input: publishes a heartbeat when it is due, polls for a short time after the last
    /// chunk, then blocks on the wake pipe.
    fn idle(&mut self) -> Result<(), ChannelError> {
        self.publish_if_due()?;
        if keep_polling(self.active_at.elapsed()) {
            return Ok(());
        }
        if self.cleaned_at.elapsed() >= CLEANUP_INTERVAL {
            self.participant.clean_up_dead();
            self.cleaned_at = now();
        }
        self.feedback_publisher.loan_pool.refill(LOANS_AHEAD)?;
        self.has_slept = true;
        self.participant.refresh_description();
        self.participant.chunk_wake_pipe.wait(HEARTBEAT_INTERVAL);
        Ok(())
    }
}

/// Writes a decision into the journal before the planner receives it.
fn record(journal: &mut Journal, decided: &StreamState, walk: WalkProgress) {
    let feedback = decided.feedback(decided.stats().received, walk);
    journal.write(decided.stream_after_first(), &feedback);
}

/// Result of one receive call.
enum Receipt {
    Nothing,
    Ignored,
    Checked,
}

impl FeedbackPublisher {
    fn open(participant: &Participant) -> Result<Self, ChannelError> {
        let publisher =
            participant.feedback.publisher_builder().max_loaned_samples(FEEDBACK_POOL).create();
        let publisher = publisher
            .map_err(|error| ChannelError::transport("creating the feedback publisher", error))?;
        participant.instance.reserve_segments()?;
        let loan_pool = LoanPool::new(publisher, FEEDBACK_POOL, LOANS_AHEAD)?;
        name_publisher(&participant.instance, PublisherRole::Controller, loan_pool.publisher_id())?;
        Ok(Self {
            loan_pool,
            walk: Rc::default(),
            count: 0,
            published_at: now(),
            answered_at: now(),
            faults: None,
        })
    }

    /// Whether it is time for a heartbeat.
    fn is_due(&self) -> bool {
        self.published_at.elapsed() >= HEARTBEAT_INTERVAL
    }

    /// Publishes feedback and wakes a planner that may be blocked.
    fn publish_and_notify(
        &mut self,
        feedback: Feedback,
        may_sleep: bool,
        wake_pipe: &WakePipe,
    ) -> Result<(), ChannelError> {
        let may_sleep = may_sleep || self.answered_at.elapsed() >= PEER_POLLING_TIME;
        self.send(feedback)?;
        self.answered_at = self.published_at;
        if may_sleep {
            wake_pipe.notify();
        }
        Ok(())
    }

    /// Publishes the current feedback.
    fn publish(&mut self, stream_state: &StreamState) -> Result<(), ChannelError> {
        let feedback = self.next_feedback(stream_state);
        self.send(feedback)
    }

    fn next_feedback(&mut self, stream_state: &StreamState) -> Feedback {
        self.count += 1;
        stream_state.feedback(self.count, self.walk.get())
    }

    /// Sends feedback in a loaned sample.
    fn send(&mut self, feedback: Feedback) -> Result<(), ChannelError> {
        let delivered = match &mut self.faults {
            Some(faults) => faults.delivered(feedback),
            None => Some(feedback),
        };
        self.published_at = now();
        let Some(feedback) = delivered else { return Ok(()) };
        let sent = self.loan_pool.take()?.write_payload(feedback).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending feedback", error))
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "time decides when feedback is repeated and has no influence on the checks"
)]
fn now() -> Instant {
    Instant::now()
}
