//! The controller's end of the transport: receives chunks in order, once each, and says how far it
//! got.
//!
//! A chunk is judged where it lies in shared memory. Which chunks reach the judge is decided in
//! `position`; this file adds shared memory and the clock. Feedback is cumulative and repeated, so
//! that a planner that joins late, or missed a word, learns it. `journal` keeps where the robot
//! stands for the controller that takes over when this one is killed.

mod journal;
mod lateness;
mod position;
mod state;

use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{PortFactory, ipc};
use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::instance::bell::{AWAKE_FOR, Bell, stay_awake};
use surefoot_shared_types::instance::service::{CREDIT, STOCK, WORD_POOL};
use surefoot_shared_types::instance::stock::Stock;
use surefoot_shared_types::instance::{Instance, Link};
use surefoot_shared_types::message::{Check, Correction, Feedback, Margins, PlanChunk};

pub use surefoot_shared_types::instance::ChannelError;

pub use state::StatePublisher;

use journal::Journal;
use lateness::Lateness;
use position::{Admission, Position};

/// Time between two heartbeats while there is nothing to read.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(1);
/// Time between two cleanings of what dead processes hold, while there is nothing to read.
const CLEAN_EVERY: Duration = Duration::from_millis(500);

/// What the judge thinks of a chunk.
#[derive(Debug, Clone, PartialEq)]
pub enum Judgement {
    /// Walked; these were its worst margins, and this is the digest of the stream with it
    /// ([`PlanChunk::stream_after`]), which the word tells.
    Accepted(Margins, Digest),
    /// As before, but walked as this chunk says, since the robot's feet stand elsewhere than
    /// planned.
    AcceptedAs(Margins, Digest, Box<PlanChunk>),
    /// Not walked.
    Refused {
        /// What it violates.
        check: Check,
        /// Where in the chunk.
        waypoint: u32,
        /// With [`Check::WorldDiffers`], what was met. From the next epoch on the chunks must carry
        /// the digest of the world so corrected
        /// (`surefoot_shared_types::scene::correction::corrected_digest`).
        correction: Option<Correction>,
    },
}

/// Judges chunks, each once and in order. While it works it may call `alive` now and then, so that
/// the planner hears that the controller lives.
pub type Judge<'a> = dyn FnMut(&PlanChunk, &mut dyn FnMut()) -> Judgement + 'a;

/// A refused chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal {
    /// The place of the refused chunk: the one that was expected next.
    pub sequence: u64,
    /// What it violates.
    pub check: Check,
    /// Where in the chunk.
    pub waypoint: u32,
}

/// How listening ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The plan's last chunk is accepted.
    Finished,
    /// A chunk is refused; the robot stands at the end of the one before.
    Refused(Refusal),
    /// No planner is attached any more, and the plan is not finished; the robot stands at the end
    /// of the last chunk that it walked. Told once until another chunk comes.
    Left,
    /// The caller ended it.
    Stopped,
}

/// Chunks received since the instance's start, by what became of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// All of them.
    pub received: u64,
    /// Judged and accepted.
    pub accepted: u64,
    /// Accepted before, and not walked again.
    pub duplicates: u64,
    /// Ahead of a chunk that is still missing, and ignored: the planner sends them again.
    pub gaps: u64,
    /// Of a planner session or plan that is over.
    pub leftovers: u64,
    /// Meant for another controller instance.
    pub foreign: u64,
}

/// Receives chunks and answers.
pub struct ChunkReceiver {
    subscriber: Subscriber<ipc::Service, PlanChunk, ()>,
    mouth: Mouth,
    link: Link,
    position: Position,
    journal: Journal,
    taken_over: Option<Feedback>,
    active_at: Instant,
    cleaned_at: Instant,
    told_left: bool,
    /// Whether it slept since it last answered: then nobody knows whether the planner did, too.
    has_slept: bool,
}

/// The end that speaks.
struct Mouth {
    stock: Stock<Feedback>,
    words: u64,
    spoke_at: Instant,
    /// When it answered last: heartbeats wake nobody.
    answered_at: Instant,
    lateness: Option<Lateness>,
}

impl ChunkReceiver {
    /// Enters the instance as a controller, where the one before left the robot. `id` must not be 0
    /// and must differ from that of every controller before (`instance::draw_id`): chunks are
    /// addressed to it.
    ///
    /// # Errors
    /// `id` is 0, another controller moves the robot of this instance, the journal cannot be read
    /// or written, a service has another message layout, or the transport fails.
    pub fn open(instance: &Instance, id: u64) -> Result<Self, ChannelError> {
        if id == 0 {
            return Err(ChannelError::Id);
        }
        let link = Link::open(instance)?;
        let (journal, record) = Journal::open(instance)?;
        let subscriber = link.chunks.subscriber_builder().buffer_size(CREDIT).create();
        let subscriber = subscriber
            .map_err(|error| ChannelError::transport("creating the chunk subscriber", error))?;
        let mouth = Mouth::open(&link)?;
        instance.reserve_segments()?;
        let position =
            record.map_or_else(|| Position::new(id), |record| Position::take_over(id, &record));
        let taken_over = record.map(|record| record.word);
        let start = now();
        let mut receiver = Self {
            subscriber,
            mouth,
            link,
            position,
            journal,
            taken_over,
            active_at: start,
            cleaned_at: start,
            told_left: false,
            has_slept: true,
        };
        receiver.mouth.say(&receiver.position)?;
        Ok(receiver)
    }

    /// Where to say how the simulated robot is.
    ///
    /// # Errors
    /// The transport fails.
    pub fn open_state(&self) -> Result<StatePublisher, ChannelError> {
        StatePublisher::open(&self.link)
    }

    /// Loses and delays words on purpose, as the seed says. Any word may be missed, so nothing may
    /// come of it.
    pub fn disturb_words(&mut self, seed: u64) {
        self.mouth.lateness = Some(Lateness::new(seed));
    }

    /// The last word of the controller whose robot this one took over, if there was one.
    pub fn taken_over(&self) -> Option<&Feedback> {
        self.taken_over.as_ref()
    }

    /// Listens until the plan is finished, a chunk is refused, or `keep_going` says no. `judge`
    /// sees each chunk once, in order, its CRC checked, and that it names the stream so far. Call
    /// it again to wait for a new plan or epoch.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn run(
        &mut self,
        judge: &mut Judge<'_>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Ended, ChannelError> {
        while keep_going() {
            match self.take_one(judge)? {
                Took::Nothing => {
                    self.idle()?;
                    if self.is_left() {
                        return Ok(Ended::Left);
                    }
                }
                Took::Leftover => self.active_at = now(),
                Took::Judged => {
                    self.active_at = now();
                    self.told_left = false;
                    if let Some(ended) = self.ended() {
                        return Ok(ended);
                    }
                }
            }
        }
        Ok(Ended::Stopped)
    }

    /// How the stream ended at which the robot stands, if it did. A controller that takes over need
    /// not wait for a chunk then.
    pub fn ended(&self) -> Option<Ended> {
        let refused = self.position.refusal().map(Ended::Refused);
        refused.or(self.position.is_finished().then_some(Ended::Finished))
    }

    /// Goes on after an end: repeats the last word, so that the planner learns it, and walks
    /// whatever new plan or epoch comes. Answers its end, or nothing once `keep_going` says no.
    /// With a `longest`, also nothing when no planner is attached or none has begun anything for so
    /// long.
    ///
    /// # Errors
    /// The transport or the journal fails.
    pub fn linger(
        &mut self,
        judge: &mut Judge<'_>,
        longest: Option<Duration>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Ended>, ChannelError> {
        let start = now();
        while keep_going() {
            let is_alone = || self.link.chunks.dynamic_config().number_of_publishers() == 0;
            if longest.is_some_and(|longest| start.elapsed() >= longest || is_alone()) {
                return Ok(None);
            }
            match self.take_one(judge)? {
                Took::Judged if self.ended().is_some() => return Ok(self.ended()),
                Took::Judged => return self.run(judge, keep_going).map(Some),
                Took::Nothing | Took::Leftover => self.idle()?,
            }
        }
        Ok(None)
    }

    /// Whether the planner left in the middle of its plan, and that was not told yet.
    fn is_left(&mut self) -> bool {
        let mid_plan = self.position.is_mid_plan() && !self.told_left;
        let left = mid_plan && self.link.chunks.dynamic_config().number_of_publishers() == 0;
        self.told_left |= left;
        left
    }

    /// What was received so far.
    pub fn tally(&self) -> Tally {
        self.position.tally()
    }

    /// The word that the planner gets now.
    pub fn feedback(&self) -> Feedback {
        self.position.feedback(self.mouth.words)
    }

    /// Receives a chunk and answers it.
    fn take_one(&mut self, judge: &mut Judge<'_>) -> Result<Took, ChannelError> {
        let received = self
            .subscriber
            .receive()
            .map_err(|error| ChannelError::transport("receiving a chunk", error))?;
        let Some(sample) = received else { return Ok(Took::Nothing) };
        let chunk = sample.payload();
        match self.position.admit(chunk) {
            Admission::Ignore => return Ok(Took::Leftover),
            Admission::Refuse(check) => self.position.refuse(check, 0, None),
            Admission::Judge => self.judge(chunk, judge)?,
        }
        let word = self.mouth.next_word(&self.position);
        self.journal.keep(self.position.stream_after_first(), &word);
        let may_sleep = std::mem::take(&mut self.has_slept);
        self.mouth.answer(word, may_sleep, &self.link.feedback_bell)?;
        Ok(Took::Judged)
    }

    /// Has a chunk judged, with heartbeats when the judge takes long.
    fn judge(&mut self, chunk: &PlanChunk, judge: &mut Judge<'_>) -> Result<(), ChannelError> {
        let (mouth, position) = (&mut self.mouth, &mut self.position);
        position.set_busy(true);
        let mut said = Ok(());
        let judgement = judge(chunk, &mut || {
            if said.is_ok() && mouth.is_due() {
                said = mouth.say(position);
            }
        });
        position.set_busy(false);
        match judgement {
            Judgement::Accepted(margins, stream) => position.accept(chunk, stream, &margins, chunk),
            Judgement::AcceptedAs(margins, stream, walked) => {
                position.accept(chunk, stream, &margins, &walked)
            }
            Judgement::Refused { check, waypoint, correction } => {
                position.refuse(check, waypoint, correction)
            }
        }
        said
    }

    /// Nothing to read: a heartbeat when it is time; a short spin after something happened, then
    /// sleep until the bell.
    fn idle(&mut self) -> Result<(), ChannelError> {
        if self.mouth.is_due() {
            self.mouth.say(&self.position)?;
        }
        if stay_awake(self.active_at.elapsed()) {
            return Ok(());
        }
        if self.cleaned_at.elapsed() >= CLEAN_EVERY {
            self.link.node.try_cleanup_dead_nodes();
            self.cleaned_at = now();
        }
        self.mouth.stock.refill(STOCK)?;
        self.has_slept = true;
        self.link.chunk_bell.wait(HEARTBEAT_EVERY);
        Ok(())
    }
}

/// What came of a look at the chunks.
enum Took {
    Nothing,
    Leftover,
    Judged,
}

impl Mouth {
    fn open(link: &Link) -> Result<Self, ChannelError> {
        let publisher = link.feedback.publisher_builder().max_loaned_samples(WORD_POOL).create();
        let publisher = publisher
            .map_err(|error| ChannelError::transport("creating the feedback publisher", error))?;
        link.instance.reserve_segments()?;
        Ok(Self {
            stock: Stock::new(publisher, WORD_POOL, STOCK)?,
            words: 0,
            spoke_at: now(),
            answered_at: now(),
            lateness: None,
        })
    }

    /// Whether it is time for a heartbeat.
    fn is_due(&self) -> bool {
        self.spoke_at.elapsed() >= HEARTBEAT_EVERY
    }

    /// Says a word, and wakes a planner that has waited for it.
    fn answer(&mut self, word: Feedback, may_sleep: bool, bell: &Bell) -> Result<(), ChannelError> {
        let may_sleep = may_sleep || self.answered_at.elapsed() >= AWAKE_FOR;
        self.send(word)?;
        self.answered_at = self.spoke_at;
        if may_sleep {
            bell.ring();
        }
        Ok(())
    }

    /// Says where the robot stands.
    fn say(&mut self, position: &Position) -> Result<(), ChannelError> {
        let word = self.next_word(position);
        self.send(word)
    }

    fn next_word(&mut self, position: &Position) -> Feedback {
        self.words += 1;
        position.feedback(self.words)
    }

    /// Sends a word in a slot that was loaned before.
    fn send(&mut self, word: Feedback) -> Result<(), ChannelError> {
        let arriving = match &mut self.lateness {
            Some(lateness) => lateness.arriving(word),
            None => Some(word),
        };
        self.spoke_at = now();
        let Some(word) = arriving else { return Ok(()) };
        let sent = self.stock.take()?.write_payload(word).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending feedback", error))
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "time decides only when to repeat a word, never what is judged"
)]
fn now() -> Instant {
    Instant::now()
}
