//! Execution in simulated time: configuration, foot forces and joint torques at every tick.
//!
//! Quasi-static: the robot tracks the chunk exactly, and at every tick the contact forces are those
//! of least squares within the friction pyramids.

use bytemuck::Zeroable;
use surefoot_shared_types::base::limits::CONTACTS_MAX;
use surefoot_shared_types::message::chunk::{FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::simulation_state::{FootForce, STATE_SCHEMA};
use surefoot_shared_types::message::{PlanChunk, SimulationState, Waypoint};

use crate::check::checker::{Checker, SoleSupports};
use crate::execution::chunk_walk::ChunkWalk;
use crate::execution::plan_motion::planned_in;
use crate::kinematics::forward::Configuration;
use crate::statics::ContactLoad;

/// Simulates accepted chunks, tick by tick.
#[derive(Debug)]
pub struct Simulation {
    controller_id: u64,
    tick_seconds: f64,
    ticks: u64,
    /// The supports of the soles in the chunk of the last tick.
    supports: Option<(ChunkNumber, SoleSupports)>,
}

/// Plan, epoch and sequence number of a chunk.
type ChunkNumber = (u64, u64, u64);

impl Simulation {
    /// A controller's simulation with a tick every `tick_seconds`, which must be positive.
    pub fn new(controller_id: u64, tick_seconds: f64) -> Self {
        Self { controller_id, tick_seconds, ticks: 0, supports: None }
    }

    /// Executes a chunk that `checker` accepts. `publish` is called once for every instant of the
    /// plan that is a multiple of the tick, over all its chunks, and for the plan's end.
    pub fn execute(
        &mut self,
        checker: &mut Checker,
        chunk: &PlanChunk,
        publish: &mut dyn FnMut(&SimulationState),
    ) {
        for time in self.instants(chunk) {
            let waypoint = planned_in(chunk, time);
            publish(&self.tick(checker, chunk, waypoint));
        }
    }

    /// The state of a robot that walks, at this instant: the next tick. Nothing before its first
    /// plan.
    pub fn state(&mut self, checker: &mut Checker, walk: &ChunkWalk) -> Option<SimulationState> {
        let (chunk, waypoint) = walk.now()?;
        Some(self.tick(checker, chunk, waypoint))
    }

    fn tick(
        &mut self,
        checker: &mut Checker,
        chunk: &PlanChunk,
        waypoint: Waypoint,
    ) -> SimulationState {
        let number = (chunk.plan_id, chunk.epoch, chunk.sequence);
        let known = self.supports.take().filter(|(of, _)| *of == number);
        let supports = known.map_or_else(
            || checker.sole_supports(chunk.contacts(), chunk.waypoints()),
            |(_, supports)| supports,
        );
        self.ticks += 1;
        let state = self.state_of(checker, chunk, &supports, &waypoint);
        self.supports = Some((number, supports));
        state
    }

    fn instants(&self, chunk: &PlanChunk) -> impl Iterator<Item = f64> + use<> {
        let waypoints = chunk.waypoints();
        let (begin, end) = (waypoints[0].time, waypoints[waypoints.len() - 1].time);
        let tick_seconds = self.tick_seconds;
        let last_before = |time: f64| (time / tick_seconds).floor() as i64;
        let is_first = chunk.flags & FLAG_FIRST != 0;
        let (first, last) = (last_before(begin) + i64::from(!is_first), last_before(end));
        let at_end =
            (chunk.flags & FLAG_LAST != 0 && last as f64 * tick_seconds < end).then_some(end);
        (first..=last)
            .map(move |index| (index as f64 * tick_seconds).clamp(begin, end))
            .chain(at_end)
    }

    fn state_of(
        &self,
        checker: &mut Checker,
        chunk: &PlanChunk,
        sole_supports: &SoleSupports,
        waypoint: &Waypoint,
    ) -> SimulationState {
        let configuration = Configuration::of_waypoint(waypoint, checker.model().joints.len());
        let load = checker.load(sole_supports, &configuration);
        let mut state = SimulationState {
            schema: STATE_SCHEMA,
            controller_id: self.controller_id,
            plan_id: chunk.plan_id,
            epoch: chunk.epoch,
            sequence: chunk.sequence,
            tick: self.ticks,
            mode: chunk.mode,
            waypoint: *waypoint,
            ..SimulationState::zeroed()
        };
        write_load(&mut state, &load, checker.model().joints.len());
        state
    }
}

fn write_load(state: &mut SimulationState, load: &ContactLoad, joints: usize) {
    state.centre_of_mass = load.centre_of_mass.to_array();
    (state.balance_margin, state.friction_use, state.torque_use) =
        (load.balance_margin, load.friction_use, load.torque_use);
    state
        .torques
        .iter_mut()
        .zip(&load.torques[..joints])
        .for_each(|(slot, torque)| *slot = *torque);
    for (slot, foot) in state.feet.iter_mut().zip(&load.feet) {
        *slot = FootForce {
            limb: foot.limb as u64,
            force: foot.force.to_array(),
            centre: foot.centre.to_array(),
        };
    }
    state.feet_len = load.feet.len().min(CONTACTS_MAX) as u32;
}
