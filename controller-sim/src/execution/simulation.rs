//! Execution in simulated time: configuration, foot forces and joint torques at every tick.
//!
//! The robot tracks the chunk exactly, and at every tick the contact forces are those of least
//! squares within the friction pyramids: in a smooth chunk by inverse dynamics, in a quasi-static
//! one those of a robot at rest.

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

    /// The instants (s) of a chunk that are multiples of the tick, over all chunks of a plan each
    /// once, and the plan's end.
    pub fn instants(&self, chunk: &PlanChunk) -> impl Iterator<Item = f64> + use<> {
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

    /// The load of a robot that executes a chunk, which `checker` accepts, at a time (s).
    pub fn load_at(
        &mut self,
        checker: &mut Checker,
        chunk: &PlanChunk,
        time: f64,
    ) -> (Waypoint, ContactLoad) {
        let waypoint = planned_in(chunk, time);
        let load = self.load_of(checker, chunk, &waypoint);
        (waypoint, load)
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
        self.ticks += 1;
        let load = self.load_of(checker, chunk, &waypoint);
        let mut state = SimulationState {
            schema: STATE_SCHEMA,
            controller_id: self.controller_id,
            plan_id: chunk.plan_id,
            epoch: chunk.epoch,
            sequence: chunk.sequence,
            tick: self.ticks,
            mode: chunk.mode,
            waypoint,
            ..SimulationState::zeroed()
        };
        write_load(&mut state, &load, checker.model().joints.len());
        state
    }

    /// The load at a waypoint of a chunk. Straight lines have no accelerations.
    fn load_of(
        &mut self,
        checker: &mut Checker,
        chunk: &PlanChunk,
        waypoint: &Waypoint,
    ) -> ContactLoad {
        let number = (chunk.plan_id, chunk.epoch, chunk.sequence);
        let known = self.supports.take().filter(|(of, _)| *of == number);
        let supports = known.map_or_else(
            || checker.sole_supports(chunk.contacts(), chunk.waypoints()),
            |(_, supports)| supports,
        );
        let load = if chunk.is_smooth() {
            checker.moving_load(&supports, waypoint)
        } else {
            let joints = checker.model().joints.len();
            checker.load(&supports, &Configuration::of_waypoint(waypoint, joints))
        };
        self.supports = Some((number, supports));
        load
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
