//! Executes accepted chunks in simulated time and publishes the robot's state at every tick.

use std::time::Duration;

use surefoot_controller_sim::ChunkExecutor;
use surefoot_controller_sim::channel::StatePublisher;
use surefoot_controller_sim::channel::plan_subscriber::PlanSubscriber;
use surefoot_controller_sim::execution::simulation::Simulation;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::message::PlanChunk;

use crate::report::liveness;
use crate::system::clock::Stopwatch;

/// Simulated time between two ticks, s.
const TICK_SECONDS: f64 = 0.01;
/// The longest sleep while real time catches up.
const SLEEP: Duration = Duration::from_millis(1);
/// Longest delay of a chunk that the simulation makes up for; after a longer one the robot has
/// stood still, s.
const LATE_SECONDS_MAX: f64 = 0.1;

/// The simulated walk of one controller.
pub struct Simulated {
    simulation: Simulation,
    publisher: StatePublisher,
    pace: Pace,
}

impl Simulated {
    /// Walks at `rate` times real time, or as fast as it can if that is 0.
    ///
    /// # Errors
    /// When the state service cannot be opened.
    pub fn new(
        subscriber: &PlanSubscriber,
        controller_id: u64,
        rate: f64,
    ) -> Result<Self, ChannelError> {
        let pace = Pace { watch: Stopwatch::start(), rate, over_at: 0.0 };
        Ok(Self {
            simulation: Simulation::new(controller_id, TICK_SECONDS),
            publisher: subscriber.open_state()?,
            pace,
        })
    }

    /// Walks an accepted chunk; `heartbeat` is called while real time catches up. A signal ends the
    /// waiting.
    ///
    /// # Errors
    /// When a state cannot be sent.
    pub fn walk(
        &mut self,
        executor: &mut ChunkExecutor,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<(), ChannelError> {
        let waypoints = chunk.waypoints();
        let (begin, end) = (waypoints[0].time, waypoints[waypoints.len() - 1].time);
        let (publisher, pace) = (&mut self.publisher, &mut self.pace);
        pace.begin();
        let mut result = Ok(());
        executor.simulate(&mut self.simulation, chunk, &mut |state| {
            pace.wait(state.waypoint.time - begin, heartbeat);
            if result.is_ok() {
                result = publisher.publish(state);
            }
        });
        pace.wait(end - begin, heartbeat);
        pace.end(end - begin);
        publisher.refill()?;
        result
    }
}

/// Keeps simulated time in step with real time.
struct Pace {
    watch: Stopwatch,
    rate: f64,
    /// When the chunk before is, or was to be, over, s.
    over_at: f64,
}

impl Pace {
    /// Begins a chunk when the one before is over, or now if that is long ago.
    fn begin(&mut self) {
        let now = self.watch.seconds();
        if now - self.over_at > LATE_SECONDS_MAX {
            self.over_at = now;
        }
    }

    /// Waits until the robot is `seconds` of simulated time within the chunk.
    fn wait(&self, seconds: f64, heartbeat: &mut dyn FnMut()) {
        heartbeat();
        while self.rate > 0.0
            && self.watch.seconds() < self.over_at + seconds / self.rate
            && liveness::keep_going()
        {
            std::thread::sleep(SLEEP);
            heartbeat();
        }
    }

    fn end(&mut self, seconds: f64) {
        if self.rate > 0.0 {
            self.over_at += seconds / self.rate;
        }
    }
}
