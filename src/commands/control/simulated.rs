//! Walks accepted chunks in simulated time and says at every tick how the robot is.

use std::time::Duration;

use surefoot_controller_sim::Walker;
use surefoot_controller_sim::channel::{ChannelError, ChunkReceiver, StatePublisher};
use surefoot_controller_sim::simulation::Simulation;
use surefoot_shared_types::message::PlanChunk;

use crate::clock::Stopwatch;

/// Simulated time between two ticks, s.
const TICK_SECONDS: f64 = 0.01;
/// The longest sleep while real time catches up.
const NAP: Duration = Duration::from_millis(1);

/// The simulated walk of one controller.
pub struct Simulated {
    simulation: Simulation,
    publisher: StatePublisher,
    rate: f64,
}

impl Simulated {
    /// Walks at `rate` times real time, or as fast as it can if that is 0.
    ///
    /// # Errors
    /// When the state service cannot be opened.
    pub fn new(receiver: &ChunkReceiver, instance: u64, rate: f64) -> Result<Self, ChannelError> {
        Ok(Self { simulation: Simulation::new(instance, TICK_SECONDS), publisher: receiver.open_state()?, rate })
    }

    /// Walks an accepted chunk; `alive` is called while real time catches up.
    ///
    /// # Errors
    /// When a state cannot be sent.
    pub fn walk(&mut self, walker: &mut Walker, chunk: &PlanChunk, alive: &mut dyn FnMut()) -> Result<(), ChannelError> {
        let (watch, begin) = (Stopwatch::start(), chunk.waypoints()[0].time);
        let (publisher, rate) = (&self.publisher, self.rate);
        let mut said = Ok(());
        walker.simulate(&mut self.simulation, chunk, &mut |state| {
            while rate > 0.0 && watch.seconds() < (state.waypoint.time - begin) / rate {
                alive();
                std::thread::sleep(NAP);
            }
            if said.is_ok() {
                said = publisher.say(state);
            }
            alive();
        });
        said
    }
}
