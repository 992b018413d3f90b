//! Walks accepted chunks in the robot's own time, and publishes its state at every tick.
//!
//! With a rate, the robot's time is real time, that many times as fast, and the robot brakes where
//! a chunk is late. Otherwise its time passes only while it walks what it has, and while a chunk is
//! held back on purpose.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use surefoot_controller_sim::channel::plan_subscriber::PlanSubscriber;
use surefoot_controller_sim::channel::{JOURNAL_CHUNKS, StatePublisher, WalkJournal, WalkProgress};
use surefoot_controller_sim::execution::simulation::Simulation;
use surefoot_controller_sim::{Checker, ChunkWalk, LateChunks};
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::message::{PlanChunk, WalkRecord};

use crate::report::liveness;
use crate::system::clock::{Stopwatch, monotonic_nanos};

/// Simulated time between two ticks, s.
const TICK_SECONDS: f64 = 0.01;
/// The shortest time that passes at once, s: no rounding swallows it.
const STEP_MIN: f64 = 1e-6;
/// The longest sleep while real time catches up.
const SLEEP: Duration = Duration::from_millis(1);
/// The next chunk is taken this long before the robot would have to brake, s; real time where the
/// robot walks in real time, since a check takes real time.
const LEAD_SECONDS: f64 = 0.3;
/// Longest delay of this process that the simulation makes up for, s of real time.
const BEHIND_SECONDS_MAX: f64 = 0.1;

/// The walk of one controller.
pub(crate) struct PacedWalk {
    walk: ChunkWalk,
    late: Option<LateChunks>,
    late_chunks: u64,
    clock: RobotTime,
    states: Option<StateTicks>,
    progress: Rc<Cell<WalkProgress>>,
    journal: WalkJournal,
}

/// How a controller walks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct WalkOptions {
    /// How many times as fast as real time, and the state is published; 0: as fast as possible.
    pub(crate) rate: Option<f64>,
    /// Which chunks are held back.
    pub(crate) late: Option<LateChunks>,
    /// Whether the motion is recorded as executed.
    pub(crate) is_recorded: bool,
}

/// Publishes the state at every tick.
struct StateTicks {
    simulation: Simulation,
    publisher: StatePublisher,
    /// The first error.
    result: Result<(), ChannelError>,
}

impl PacedWalk {
    /// A robot that has no plan yet.
    ///
    /// # Errors
    /// When the state service cannot be opened.
    pub(crate) fn new(
        subscriber: &PlanSubscriber,
        controller_id: u64,
        options: &WalkOptions,
    ) -> Result<Self, ChannelError> {
        let open = |_| -> Result<StateTicks, ChannelError> {
            let simulation = Simulation::new(controller_id, TICK_SECONDS);
            let publisher = subscriber.open_state()?;
            Ok(StateTicks { simulation, publisher, result: Ok(()) })
        };
        Ok(Self {
            walk: if options.is_recorded { ChunkWalk::recorded() } else { ChunkWalk::default() },
            late: options.late,
            late_chunks: 0,
            clock: RobotTime::new(options.rate.unwrap_or(0.0)),
            states: options.rate.map(open).transpose()?,
            progress: subscriber.walk_progress(),
            journal: subscriber.walk_journal()?,
        })
    }

    /// Takes over a robot that another controller moved: these are the last chunks that it
    /// accepted, and where in them the robot was. In real time it has walked on since, as far as
    /// the chunks allow.
    pub(crate) fn take_over(&mut self, (chunks, walk): (&[PlanChunk], Option<&WalkRecord>)) {
        let is_recorded = self.walk.take_over(chunks, walk);
        if let Some(walk) = walk.filter(|_| is_recorded && self.clock.is_real) {
            let nanos = monotonic_nanos().saturating_sub(walk.at_nanos);
            self.walk.advance(1e-9 * nanos as f64 * self.clock.rate);
        }
        self.clock.begin();
        self.note_progress();
    }

    /// The first error of publishing since the last call.
    pub(crate) fn error(&mut self) -> Result<(), ChannelError> {
        let result = self.states.as_mut().map(|states| &mut states.result);
        result.map_or(Ok(()), |result| std::mem::replace(result, Ok(())))
    }

    /// Chunks that were held back so far.
    pub(crate) fn late_chunks(&self) -> u64 {
        self.late_chunks
    }

    /// The motion as executed so far; nothing if it is not recorded.
    pub(crate) fn executed(&self) -> Vec<PlanChunk> {
        self.walk.executed()
    }

    /// What the robot does before the controller checks a chunk: it comes to rest for a new plan,
    /// and goes on with what it has where the chunk is held back.
    pub(crate) fn await_chunk(
        &mut self,
        chunk: &PlanChunk,
        checker: &mut Checker,
        heartbeat: &mut dyn FnMut(),
    ) {
        if chunk.sequence == 0 {
            return self.come_to_rest(checker, heartbeat);
        }
        let delay = self.late.and_then(|late| late.delay(chunk.epoch, chunk.sequence));
        let Some(delay) = delay else { return };
        self.late_chunks += 1;
        let until = self.clock.seconds + delay;
        self.walk_while(checker, heartbeat, &|walk| until - walk.clock.seconds);
    }

    /// The robot has accepted a chunk. It walks until it needs the next one; after the last one of
    /// a plan, to the plan's end.
    pub(crate) fn accept(
        &mut self,
        chunk: &PlanChunk,
        checker: &mut Checker,
        heartbeat: &mut dyn FnMut(),
    ) {
        self.catch_up(checker);
        self.walk.accept(chunk);
        if chunk.sequence == 0 {
            self.clock.begin();
            self.publish(checker);
        }
        self.note_progress();
        self.walk_on(checker, heartbeat);
        if let Some(states) = &mut self.states {
            let refilled = states.publisher.refill();
            states.note(refilled);
        }
    }

    /// Walks until the robot needs the next chunk; after the last one of a plan, to its end.
    fn walk_on(&mut self, checker: &mut Checker, heartbeat: &mut dyn FnMut()) {
        self.walk_while(checker, heartbeat, &|paced| {
            let walk = &paced.walk;
            if walk.is_finished() {
                return 0.0;
            }
            // The journal keeps all chunks that the robot has not passed.
            let has_too_many = walk.chunks_ahead() >= JOURNAL_CHUNKS && !walk.is_at_rest();
            let ends = if has_too_many { f64::INFINITY } else { walk.seconds_to_brake() };
            if ends.is_finite() { ends - paced.clock.lead() } else { ends }
        });
    }

    /// The robot brakes, where it moves, and stands.
    pub(crate) fn come_to_rest(&mut self, checker: &mut Checker, heartbeat: &mut dyn FnMut()) {
        let moves = |walk: &Self| if walk.walk.is_at_rest() { 0.0 } else { f64::INFINITY };
        self.walk_while(checker, heartbeat, &moves);
        self.note_progress();
    }

    /// Where the robot's time is real time, walks up to now.
    pub(crate) fn catch_up(&mut self, checker: &mut Checker) {
        if self.walk.is_finished() || self.walk.now().is_none() {
            self.clock.begin();
        }
        while self.clock.is_due(TICK_SECONDS) {
            self.pass(TICK_SECONDS, checker);
        }
    }

    /// Walks as long as `left` says that it is to go on for some time (s). A signal ends the
    /// waiting for real time: the robot goes on at once then.
    fn walk_while(
        &mut self,
        checker: &mut Checker,
        heartbeat: &mut dyn FnMut(),
        left: &dyn Fn(&Self) -> f64,
    ) {
        loop {
            let seconds = left(self);
            if seconds <= 0.0 {
                return;
            }
            heartbeat();
            while self.clock.is_real && !self.clock.is_due(TICK_SECONDS) && liveness::keep_going() {
                std::thread::sleep(SLEEP);
                heartbeat();
            }
            let is_ticking = self.states.is_some() || !seconds.is_finite();
            self.pass(if is_ticking { TICK_SECONDS } else { seconds.max(STEP_MIN) }, checker);
        }
    }

    /// Lets `seconds` of the robot's time pass, and publishes its state.
    fn pass(&mut self, seconds: f64, checker: &mut Checker) {
        self.walk.advance(seconds);
        self.clock.seconds += seconds;
        self.publish(checker);
        self.note_progress();
    }

    fn publish(&mut self, checker: &mut Checker) {
        let Some(states) = &mut self.states else { return };
        if let Some(state) = states.simulation.state(checker, &self.walk) {
            let published = states.publisher.publish(&state);
            states.note(published);
        }
    }

    /// Records where the robot is. A robot whose time stands still without a chunk counts as one
    /// that stands.
    fn note_progress(&mut self) {
        if let Some(record) = self.walk.record() {
            self.journal.write(WalkRecord { at_nanos: monotonic_nanos(), ..record });
        }
        let is_moving = self.clock.is_real && !self.walk.is_at_rest();
        self.progress.set(WalkProgress { is_moving, stops: self.walk.counts() });
    }
}

impl StateTicks {
    fn note(&mut self, result: Result<(), ChannelError>) {
        if self.result.is_ok() {
            self.result = result;
        }
    }
}

/// The robot's time.
struct RobotTime {
    watch: Stopwatch,
    rate: f64,
    /// Whether it is real time, times the rate.
    is_real: bool,
    /// The robot's time, s.
    seconds: f64,
    /// The real time at which the robot's time was 0, s.
    zero_at: f64,
}

impl RobotTime {
    fn new(rate: f64) -> Self {
        let watch = Stopwatch::start();
        Self { watch, rate, is_real: rate > 0.0, seconds: 0.0, zero_at: 0.0 }
    }

    /// From now on the robot's time goes on from where it is.
    fn begin(&mut self) {
        if self.is_real {
            self.zero_at = self.watch.seconds() - self.seconds / self.rate;
        }
    }

    /// Whether real time is as far as the robot's time `seconds` later.
    fn is_due(&mut self, seconds: f64) -> bool {
        if !self.is_real {
            return false;
        }
        let now = self.watch.seconds() - self.zero_at;
        let due = (self.seconds + seconds) / self.rate;
        if now - due > BEHIND_SECONDS_MAX {
            self.zero_at += now - due - BEHIND_SECONDS_MAX;
        }
        now >= due
    }

    /// How long before it would have to brake the robot takes the next chunk, s.
    fn lead(&self) -> f64 {
        if self.is_real { LEAD_SECONDS * self.rate.max(1.0) } else { LEAD_SECONDS }
    }
}
