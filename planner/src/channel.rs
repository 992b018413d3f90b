//! The planner's end of the transport: delivers the chunks of a plan, whoever is killed or stopped
//! meanwhile.
//!
//! A chunk counts as delivered only when a controller acknowledges it; what iceoryx2's `send`
//! returns counts for nothing, because readers other than the controller may listen. The protocol
//! stands in `window`, this file adds shared memory and the clock.

mod window;

use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;
use surefoot_shared_types::instance::bell::{AWAKE_FOR, stay_awake};
use surefoot_shared_types::instance::service::{CHUNK_POOL, CREDIT, STOCK};
use surefoot_shared_types::instance::stock::Stock;
use surefoot_shared_types::instance::{Instance, Link};
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, Sealed};

pub use surefoot_shared_types::instance::ChannelError;

use window::Window;

/// Time without progress after which chunks are sent again, if the controller has nothing to read.
const RESEND_AFTER: Duration = Duration::from_millis(20);
/// Time without a word from any controller after which dead processes are cleaned away, and again
/// and again after it.
const CLEAN_EVERY: Duration = Duration::from_millis(200);
/// Time without a word from any controller after which it counts as lost, unless told otherwise.
const LOST_AFTER: Duration = Duration::from_secs(30);
/// How long the sender sleeps where no bell wakes it.
const SLEEP: Duration = Duration::from_millis(4);
/// The longest time between two looks that counts as silence of the controller: whoever was stopped
/// heard nothing.
const LOOK_MAX: Duration = Duration::from_millis(100);

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
pub struct ChunkSender {
    stock: Stock<PlanChunk>,
    subscriber: Subscriber<ipc::Service, Feedback, ()>,
    link: Link,
    session: u64,
    lost_after: Duration,
    credit: usize,
}

/// A chunk that stands complete in shared memory before it may be sent.
struct Ready {
    /// Its place in the stream, and the controller it is for.
    meant: (usize, u64),
    sample: SampleMut<ipc::Service, PlanChunk, ()>,
}

/// What a delivery remembers between two looks at the controller.
struct Course<'a> {
    window: Window<'a>,
    ready: Option<Ready>,
    last_word: Option<Feedback>,
    looked_at: Instant,
    silence: Duration,
    active_at: Instant,
    progress_at: Instant,
    cleaned_at: Instant,
    /// Whether it slept since it last sent something: then nobody knows whether the controller did,
    /// too.
    has_slept: bool,
}

impl ChunkSender {
    /// Enters the instance as a planner. `session` must not be 0 and must differ from that of every
    /// planner before (`instance::draw_id`): it tells this process's chunks from a killed one's
    /// leftovers.
    ///
    /// # Errors
    /// `session` is 0, a service has another message layout, or the transport fails.
    pub fn open(instance: &Instance, session: u64) -> Result<Self, ChannelError> {
        if session == 0 {
            return Err(ChannelError::Id);
        }
        let link = Link::open(instance)?;
        let publisher = link
            .chunks
            .publisher_builder()
            .max_loaned_samples(CHUNK_POOL)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| ChannelError::transport("creating the chunk publisher", error))?;
        let subscriber =
            link.feedback.subscriber_builder().create().map_err(|error| {
                ChannelError::transport("creating the feedback subscriber", error)
            })?;
        instance.reserve_segments()?;
        let stock = Stock::new(publisher, CHUNK_POOL, STOCK)?;
        Ok(Self { stock, subscriber, link, session, lost_after: LOST_AFTER, credit: CREDIT })
    }

    /// Sets how many chunks may be on their way at a time, 1 to [`CREDIT`].
    pub fn set_credit(&mut self, credit: usize) {
        self.credit = credit.clamp(1, CREDIT);
    }

    /// This planner's session.
    pub fn session(&self) -> u64 {
        self.session
    }

    /// The latest word of whichever controller speaks, if one came since the last look.
    ///
    /// # Errors
    /// The transport fails.
    pub fn overhear(&self) -> Result<Option<Feedback>, ChannelError> {
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

    /// Waits until the controller has nothing more to read, so that the robot stays where its word
    /// says; answers that word, or nothing where no controller speaks for `longest` or `keep_going`
    /// says no.
    ///
    /// # Errors
    /// The transport fails.
    pub fn settle(
        &self,
        longest: Duration,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Feedback>, ChannelError> {
        let mut heard_at = now();
        let mut settled: Option<(Feedback, u64)> = None;
        while keep_going() && heard_at.elapsed() < longest {
            let Some(word) = self.overhear()? else {
                self.link.feedback_bell.wait(SLEEP);
                continue;
            };
            heard_at = now();
            let quiet = match &settled {
                Some((before, quiet)) if is_same_place(before, &word) => quiet + 1,
                _ => 0,
            };
            if quiet >= window::IDLE_HEARTBEATS {
                return Ok(Some(word));
            }
            settled = Some((word, quiet));
        }
        Ok(None)
    }

    /// The process's end of the instance.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// Sets how long no controller may be heard before it counts as lost.
    pub fn set_lost_after(&mut self, lost_after: Duration) {
        self.lost_after = lost_after;
    }

    /// Delivers a whole stream: complete chunks in order, to which only session, target instance
    /// and CRC are added. Returns when all are accepted, one is refused, no controller is heard for
    /// too long, or `keep_going` says no. `on_progress` gets every word of the listening
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
        self.stock.refill(STOCK)?;
        let mut course = Course::new(Window::new(chunks, self.session, self.credit)?);
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
            if sent == 0 {
                self.rest(&mut course)?;
            }
        }
    }

    fn listen(
        &self,
        course: &mut Course<'_>,
        on_progress: &mut dyn FnMut(&Feedback),
    ) -> Result<(), ChannelError> {
        course.note_look();
        while let Some(sample) = self
            .subscriber
            .receive()
            .map_err(|error| ChannelError::transport("receiving feedback", error))?
        {
            let feedback = sample.payload();
            let acknowledged = course.window.acknowledged();
            if !course.window.hear(feedback) {
                continue;
            }
            course.silence = Duration::ZERO;
            if course.window.acknowledged() != acknowledged {
                course.progress_at = course.looked_at;
                course.active_at = course.looked_at;
            }
            course.last_word = Some(*feedback);
            on_progress(feedback);
        }
        Ok(())
    }

    /// Makes the chunk ready that goes next. Looks again at once after something happened; where
    /// nothing does, fills the stock and sleeps until the bell.
    fn rest(&mut self, course: &mut Course<'_>) -> Result<(), ChannelError> {
        let coming = course
            .window
            .coming()
            .filter(|coming| course.ready.as_ref().is_none_or(|ready| ready.meant != *coming));
        if let Some(coming) = coming {
            course.ready = Some(self.place(course.window.chunk(coming.0), coming)?);
            return Ok(());
        }
        if stay_awake(course.looked_at.duration_since(course.active_at)) {
            return Ok(());
        }
        self.stock.refill(STOCK)?;
        course.has_slept = true;
        self.link.feedback_bell.wait(SLEEP);
        Ok(())
    }

    fn given_up(&self, course: &Course<'_>, keep_going: &dyn Fn() -> bool) -> Option<Outcome> {
        if !keep_going() {
            return Some(Outcome::Stopped);
        }
        (course.silence > self.lost_after).then_some(Outcome::ControllerLost)
    }

    /// Sends what the window allows; stops early when no reader took a chunk.
    fn send_open_window(&mut self, course: &mut Course<'_>) -> Result<usize, ChannelError> {
        let mut sent = 0;
        while let Some(meant) = course.window.to_send() {
            let ready = match course.ready.take().filter(|ready| ready.meant == meant) {
                Some(ready) => ready,
                None => self.place(course.window.chunk(meant.0), meant)?,
            };
            if send(ready)? == 0 {
                break;
            }
            course.window.note_sent();
            sent += 1;
        }
        if sent > 0 {
            let may_sleep =
                std::mem::take(&mut course.has_slept) || course.progress_at.elapsed() > AWAKE_FOR;
            course.progress_at = now();
            course.active_at = course.progress_at;
            if may_sleep {
                self.link.chunk_bell.ring();
            }
        }
        Ok(sent)
    }

    /// Writes a chunk into shared memory that was loaned before and completes it there.
    fn place(&mut self, chunk: &PlanChunk, meant: (usize, u64)) -> Result<Ready, ChannelError> {
        let mut sample = self.stock.take()?;
        let placed = sample.payload_mut().write(*chunk);
        (placed.session, placed.target_instance) = (self.session, meant.1);
        placed.seal();
        // SAFETY: `write` above initialised the payload.
        Ok(Ready { meant, sample: unsafe { sample.assume_init() } })
    }

    /// Frees what dead processes hold, so that a restarted controller finds room.
    fn clean_if_silent(&self, course: &mut Course<'_>) {
        if course.silence > CLEAN_EVERY && course.cleaned_at.elapsed() > CLEAN_EVERY {
            self.link.node.try_cleanup_dead_nodes();
            course.cleaned_at = now();
        }
    }
}

impl<'a> Course<'a> {
    fn new(window: Window<'a>) -> Self {
        let start = now();
        let (looked_at, active_at, progress_at, cleaned_at) = (start, start, start, start);
        let silence = Duration::ZERO;
        Self {
            window,
            ready: None,
            last_word: None,
            looked_at,
            silence,
            active_at,
            progress_at,
            cleaned_at,
            has_slept: true,
        }
    }

    /// Adds the time since the last look to the controller's silence.
    fn note_look(&mut self) {
        let look = now();
        self.silence += look.duration_since(self.looked_at).min(LOOK_MAX);
        self.looked_at = look;
    }

    fn delivery(&self, outcome: Outcome) -> Delivery {
        let (sent, resent) = self.window.counts();
        Delivery {
            outcome,
            sent,
            resent,
            accepted: self.window.acknowledged() as u64,
            feedback: self.last_word,
        }
    }
}

/// Sends a chunk that is ready. Returns how many readers took it.
fn send(ready: Ready) -> Result<usize, ChannelError> {
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

/// Whether a controller was idle between two of its words.
fn is_same_place(before: &Feedback, after: &Feedback) -> bool {
    let place = |word: &Feedback| {
        (word.instance, word.plan_id, word.epoch, word.next_sequence, word.walked)
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
