//! The controller's end of the transport: receives chunks in order, once each, and says how far it got.
//!
//! A chunk is judged where it lies in shared memory. Which chunks reach the judge is decided in `position`; this file
//! adds shared memory and the clock. Feedback is cumulative and repeated while there is nothing to read, so that a
//! planner that joins late, or missed a word, learns it.

mod position;

use std::time::{Duration, Instant};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{PortFactory, ipc};
use surefoot_shared_types::instance::service::CREDIT;
use surefoot_shared_types::instance::{Instance, Link};
use surefoot_shared_types::message::{Check, Feedback, Margins, PlanChunk};

pub use surefoot_shared_types::instance::ChannelError;

use position::{Admission, Position};

/// Time between two heartbeats while there is nothing to read.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(1);
/// Time between two cleanings of what dead processes hold, while there is nothing to read.
const CLEAN_EVERY: Duration = Duration::from_millis(500);
/// Looks at the chunks before the receiver sleeps.
const SPINS_MAX: u32 = 200;
/// How long the receiver sleeps when there is nothing to do.
const NAP: Duration = Duration::from_micros(100);

/// What the judge thinks of a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// Walked; these were its worst margins.
    Accepted(Margins),
    /// Not walked.
    Refused {
        /// What it violates.
        check: Check,
        /// Where in the chunk.
        waypoint: u32,
    },
    /// Seen before; not walked again.
    Duplicate,
}

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
#[derive(Debug)]
pub struct ChunkReceiver {
    subscriber: Subscriber<ipc::Service, PlanChunk, ()>,
    publisher: Publisher<ipc::Service, Feedback, ()>,
    link: Link,
    position: Position,
    words: u64,
    spoke_at: Instant,
    cleaned_at: Instant,
}

impl ChunkReceiver {
    /// Enters the instance as a controller. `id` must not be 0 and must differ from that of every controller before
    /// (`instance::draw_id`): chunks are addressed to it.
    pub fn open(instance: &Instance, id: u64) -> Result<Self, ChannelError> {
        if id == 0 {
            return Err(ChannelError::Id);
        }
        let link = Link::open(instance)?;
        let subscriber = link.chunks.subscriber_builder().buffer_size(CREDIT).create();
        let subscriber = subscriber.map_err(|error| ChannelError::transport("creating the chunk subscriber", error))?;
        let publisher = link.feedback.publisher_builder().max_loaned_samples(1).create();
        let publisher = publisher.map_err(|error| ChannelError::transport("creating the feedback publisher", error))?;
        let start = now();
        let mut receiver = Self { subscriber, publisher, link, position: Position::new(id), words: 0, spoke_at: start, cleaned_at: start };
        receiver.speak()?;
        Ok(receiver)
    }

    /// Listens until the plan is finished, a chunk is refused, or `keep_going` says no. `judge` sees each chunk once, in
    /// order, its CRC and stream digest checked. Call it again to wait for a new plan or epoch.
    pub fn run(&mut self, judge: &mut dyn FnMut(&PlanChunk) -> Judgement, keep_going: &dyn Fn() -> bool) -> Result<Ended, ChannelError> {
        let mut idle_rounds = 0_u32;
        while keep_going() {
            if self.take_one(judge)? {
                idle_rounds = 0;
                if let Some(ended) = self.ended() {
                    return Ok(ended);
                }
            } else {
                idle_rounds = idle_rounds.saturating_add(1);
                self.idle(idle_rounds)?;
            }
        }
        Ok(Ended::Stopped)
    }

    /// Repeats the last word until no planner is attached, `keep_going` says no, or `longest` has passed, so that the
    /// planner learns the end. Chunks that still arrive are not judged.
    pub fn linger(&mut self, longest: Duration, keep_going: &dyn Fn() -> bool) -> Result<(), ChannelError> {
        let start = now();
        while keep_going() && start.elapsed() < longest && self.link.chunks.dynamic_config().number_of_publishers() > 0 {
            self.idle(SPINS_MAX)?;
        }
        Ok(())
    }

    /// What was received so far.
    pub fn tally(&self) -> Tally {
        self.position.tally()
    }

    /// The word that the planner gets now.
    pub fn feedback(&self) -> Feedback {
        self.position.feedback(self.words)
    }

    /// Receives a chunk and answers it. False if there was none.
    fn take_one(&mut self, judge: &mut dyn FnMut(&PlanChunk) -> Judgement) -> Result<bool, ChannelError> {
        let received = self.subscriber.receive().map_err(|error| ChannelError::transport("receiving a chunk", error))?;
        let Some(sample) = received else { return Ok(false) };
        let chunk = sample.payload();
        match self.position.admit(chunk) {
            Admission::Ignore => return Ok(true),
            Admission::Refuse(check) => self.position.refuse(check, 0),
            Admission::Judge => match judge(chunk) {
                Judgement::Accepted(margins) => self.position.accept(chunk, &margins),
                Judgement::Refused { check, waypoint } => self.position.refuse(check, waypoint),
                Judgement::Duplicate => self.position.note_duplicate(),
            },
        }
        self.speak()?;
        Ok(true)
    }

    fn ended(&self) -> Option<Ended> {
        let refused = self.position.refusal().map(Ended::Refused);
        refused.or(self.position.is_finished().then_some(Ended::Finished))
    }

    /// Nothing to read: a heartbeat when it is time, then a short rest.
    fn idle(&mut self, idle_rounds: u32) -> Result<(), ChannelError> {
        if self.spoke_at.elapsed() >= HEARTBEAT_EVERY {
            self.speak()?;
        }
        if idle_rounds < SPINS_MAX {
            std::hint::spin_loop();
            return Ok(());
        }
        if self.cleaned_at.elapsed() >= CLEAN_EVERY {
            self.link.node.try_cleanup_dead_nodes();
            self.cleaned_at = now();
        }
        std::thread::sleep(NAP);
        Ok(())
    }

    fn speak(&mut self) -> Result<(), ChannelError> {
        self.words += 1;
        let sample = self.publisher.loan_uninit().map_err(|error| ChannelError::transport("loaning feedback", error))?;
        let sent = sample.write_payload(self.position.feedback(self.words)).send();
        sent.map_err(|error| ChannelError::transport("sending feedback", error))?;
        self.spoke_at = now();
        Ok(())
    }
}

#[allow(clippy::disallowed_methods, reason = "time decides only when to repeat a word, never what is judged")]
fn now() -> Instant {
    Instant::now()
}
