//! The planner's end of the transport: delivers the chunks of a plan, whoever is killed or stopped meanwhile.
//!
//! A chunk counts as delivered only when a controller acknowledges it; what iceoryx2's `send` returns counts for
//! nothing, because readers other than the controller may listen. The protocol stands in `window`, this file adds
//! shared memory and the clock.

mod window;

use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use surefoot_shared_types::instance::{Instance, Link};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk};

pub use surefoot_shared_types::instance::ChannelError;

use window::Window;

/// Time without progress after which chunks are sent again, if the controller has nothing to read.
const RESEND_AFTER: Duration = Duration::from_millis(20);
/// Time without a word from any controller after which dead processes are cleaned away, and again and again after it.
const CLEAN_EVERY: Duration = Duration::from_millis(200);
/// Time without a word from any controller after which it counts as lost, unless told otherwise.
const LOST_AFTER: Duration = Duration::from_secs(30);
/// Looks at the feedback before the sender sleeps.
const SPINS_MAX: u32 = 200;
/// How long the sender sleeps when there is nothing to do.
const NAP: Duration = Duration::from_micros(100);

/// How a delivery ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
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
    /// No controller was heard for too long, or the one that was heard never received what was sent.
    ControllerLost,
    /// The caller ended it.
    Stopped,
}

/// What became of a plan's chunks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delivery {
    /// How it ended.
    pub outcome: Outcome,
    /// Chunks put into shared memory, those sent again included.
    pub sent: u64,
    /// Chunks sent again: after a stall, or to a new controller instance.
    pub resent: u64,
    /// Chunks that the last controller instance accepted.
    pub accepted: u64,
    /// The controller's last word, if there was one.
    pub feedback: Option<Feedback>,
}

/// Sends chunks to whichever controller listens.
#[derive(Debug)]
pub struct ChunkSender {
    publisher: Publisher<ipc::Service, PlanChunk, ()>,
    subscriber: Subscriber<ipc::Service, Feedback, ()>,
    link: Link,
    session: u64,
    lost_after: Duration,
}

/// What a delivery remembers between two looks at the controller.
struct Course<'a> {
    window: Window<'a>,
    last_word: Option<Feedback>,
    heard_at: Instant,
    progress_at: Instant,
    cleaned_at: Instant,
    idle_rounds: u32,
}

impl ChunkSender {
    /// Enters the instance as a planner. `session` must not be 0 and must differ from that of every planner before
    /// (`instance::draw_id`): it tells this process's chunks from a killed one's leftovers.
    pub fn open(instance: &Instance, session: u64) -> Result<Self, ChannelError> {
        if session == 0 {
            return Err(ChannelError::Id);
        }
        let link = Link::open(instance)?;
        let publisher = link
            .chunks
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| ChannelError::transport("creating the chunk publisher", error))?;
        let subscriber = link
            .feedback
            .subscriber_builder()
            .create()
            .map_err(|error| ChannelError::transport("creating the feedback subscriber", error))?;
        Ok(Self { publisher, subscriber, link, session, lost_after: LOST_AFTER })
    }

    /// Sets how long no controller may be heard before it counts as lost.
    pub fn set_lost_after(&mut self, lost_after: Duration) {
        self.lost_after = lost_after;
    }

    /// Delivers a whole stream: complete chunks in order, to which only session, target instance and CRC are added.
    /// Returns when all are accepted, one is refused, no controller is heard for too long, or `keep_going` says no.
    /// `on_progress` gets every word of the listening controller.
    pub fn deliver(
        &mut self,
        chunks: &[PlanChunk],
        on_progress: &mut dyn FnMut(&Feedback),
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Delivery, ChannelError> {
        let mut course = Course::new(Window::new(chunks, self.session)?);
        loop {
            self.listen(&mut course, on_progress)?;
            let outcome = course.window.outcome().or_else(|| self.given_up(&course, keep_going));
            if let Some(outcome) = outcome {
                return Ok(course.delivery(outcome));
            }
            if course.progress_at.elapsed() > RESEND_AFTER && course.window.go_back() {
                course.progress_at = now();
            }
            let sent = self.send_open_window(&mut course)?;
            self.clean_if_silent(&mut course);
            course.rest(sent > 0);
        }
    }

    fn listen(&self, course: &mut Course<'_>, on_progress: &mut dyn FnMut(&Feedback)) -> Result<(), ChannelError> {
        while let Some(sample) = self.subscriber.receive().map_err(|error| ChannelError::transport("receiving feedback", error))? {
            let feedback = *sample.payload();
            let acknowledged = course.window.acknowledged();
            if !course.window.hear(&feedback) {
                continue;
            }
            course.heard_at = now();
            if course.window.acknowledged() != acknowledged {
                course.progress_at = course.heard_at;
            }
            course.last_word = Some(feedback);
            course.idle_rounds = 0;
            on_progress(&feedback);
        }
        Ok(())
    }

    fn given_up(&self, course: &Course<'_>, keep_going: &dyn Fn() -> bool) -> Option<Outcome> {
        if !keep_going() {
            return Some(Outcome::Stopped);
        }
        (course.heard_at.elapsed() > self.lost_after).then_some(Outcome::ControllerLost)
    }

    /// Sends what the window allows; stops early when no reader took a chunk.
    fn send_open_window(&self, course: &mut Course<'_>) -> Result<usize, ChannelError> {
        let mut sent = 0;
        while let Some((chunk, controller)) = course.window.to_send() {
            if self.send(chunk, controller)? == 0 {
                break;
            }
            course.window.note_sent();
            sent += 1;
        }
        if sent > 0 {
            course.progress_at = now();
        }
        Ok(sent)
    }

    /// Writes the chunk into shared memory and completes it there. Returns how many readers took it.
    fn send(&self, chunk: &PlanChunk, controller: u64) -> Result<usize, ChannelError> {
        let mut sample = self.publisher.loan_uninit().map_err(|error| ChannelError::transport("loaning a chunk", error))?;
        let placed = sample.payload_mut().write(*chunk);
        placed.session = self.session;
        placed.target_instance = controller;
        placed.seal();
        // SAFETY: `write` above initialised the payload.
        let sample = unsafe { sample.assume_init() };
        match sample.send() {
            Ok(readers) => Ok(readers),
            // A reader died or its buffer is full: the chunk goes again after the stall.
            Err(SendError::UnableToDeliver | SendError::ConnectionCorrupted | SendError::ConnectionError(_)) => Ok(0),
            Err(error) => Err(ChannelError::transport("sending a chunk", error)),
        }
    }

    /// Frees what dead processes hold, so that a restarted controller finds room.
    fn clean_if_silent(&self, course: &mut Course<'_>) {
        if course.heard_at.elapsed() > CLEAN_EVERY && course.cleaned_at.elapsed() > CLEAN_EVERY {
            self.link.node.try_cleanup_dead_nodes();
            course.cleaned_at = now();
        }
    }
}

impl<'a> Course<'a> {
    fn new(window: Window<'a>) -> Self {
        let start = now();
        Self { window, last_word: None, heard_at: start, progress_at: start, cleaned_at: start, idle_rounds: 0 }
    }

    /// Spins a little after something happened, then sleeps.
    fn rest(&mut self, busy: bool) {
        self.idle_rounds = if busy { 0 } else { self.idle_rounds.saturating_add(1) };
        if self.idle_rounds < SPINS_MAX {
            std::hint::spin_loop();
        } else {
            std::thread::sleep(NAP);
        }
    }

    fn delivery(&self, outcome: Outcome) -> Delivery {
        let (sent, resent) = self.window.counts();
        Delivery { outcome, sent, resent, accepted: self.window.acknowledged() as u64, feedback: self.last_word }
    }
}

#[allow(clippy::disallowed_methods, reason = "time decides only when to send again, never what is sent")]
fn now() -> Instant {
    Instant::now()
}
