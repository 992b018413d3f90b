//! The walk in simulated time: at every tick where the robot is, what the ground does to its feet, and what its motors do.
//!
//! Quasi-static: the robot tracks the chunk exactly, and at every tick the contact forces are those of least squares
//! within the friction pyramids.

use bytemuck::Zeroable;
use surefoot_shared_types::message::limits::CONTACTS_MAX;
use surefoot_shared_types::message::state::{FootForce, STATE_SCHEMA};
use surefoot_shared_types::message::{PlanChunk, State, Waypoint};

use crate::check::{Checker, Load};
use crate::kinematics::Configuration;

/// Simulates accepted chunks, tick by tick.
#[derive(Debug)]
pub struct Simulation {
    instance: u64,
    tick_seconds: f64,
    ticks: u64,
}

impl Simulation {
    /// A controller's simulation with a tick every `tick_seconds`, which must be positive.
    pub fn new(instance: u64, tick_seconds: f64) -> Self {
        Self { instance, tick_seconds, ticks: 0 }
    }

    /// Walks a chunk that `checker` accepts. `tell` hears of every tick, the chunk's last instant among them.
    pub fn walk(&mut self, checker: &mut Checker, chunk: &PlanChunk, tell: &mut dyn FnMut(&State)) {
        let waypoints = chunk.waypoints();
        let (begin, end) = (waypoints[0].time, waypoints[waypoints.len() - 1].time);
        let count = ((end - begin) / self.tick_seconds).ceil() as u64;
        for tick in 1..=count.max(1) {
            let time = (begin + tick as f64 * self.tick_seconds).min(end);
            let waypoint = waypoint_at(waypoints, time, checker.model().joints.len());
            self.ticks += 1;
            tell(&self.state(checker, chunk, &waypoint));
        }
    }

    fn state(&self, checker: &mut Checker, chunk: &PlanChunk, waypoint: &Waypoint) -> State {
        let configuration = Configuration::of_waypoint(waypoint, checker.model().joints.len());
        let load = checker.load(chunk.contacts(), &configuration);
        let mut state = State {
            schema: STATE_SCHEMA,
            instance: self.instance,
            plan_id: chunk.plan_id,
            epoch: chunk.epoch,
            sequence: chunk.sequence,
            tick: self.ticks,
            mode: chunk.mode,
            waypoint: *waypoint,
            ..State::zeroed()
        };
        put(&mut state, &load);
        state
    }
}

fn put(state: &mut State, load: &Load) {
    state.centre_of_mass = load.centre_of_mass.to_array();
    (state.friction_use, state.torque_use) = (load.friction_use, load.torque_use);
    state.torques.iter_mut().zip(&load.torques).for_each(|(slot, torque)| *slot = *torque);
    for (slot, foot) in state.feet.iter_mut().zip(&load.feet) {
        *slot = FootForce { limb: foot.limb as u64, force: foot.force.to_array(), centre: foot.centre.to_array() };
    }
    state.feet_len = load.feet.len().min(CONTACTS_MAX) as u32;
}

/// Where the robot is at a time within its waypoints.
fn waypoint_at(waypoints: &[Waypoint], time: f64, joints: usize) -> Waypoint {
    let after = waypoints.partition_point(|waypoint| waypoint.time < time).min(waypoints.len() - 1);
    let (from, to) = (&waypoints[after.saturating_sub(1)], &waypoints[after]);
    let seconds = to.time - from.time;
    let share = if seconds > 0.0 { ((time - from.time) / seconds).clamp(0.0, 1.0) } else { 1.0 };
    let [start, end] = [from, to].map(|waypoint| Configuration::of_waypoint(waypoint, joints));
    let Configuration { world_from_root, q } = start.towards(&end, share);
    let mut waypoint = Waypoint { time, ..*to };
    waypoint.root_position = world_from_root.translation.to_array();
    waypoint.root_rotation = world_from_root.rotation.to_array();
    waypoint.q.iter_mut().zip(q).for_each(|(slot, position)| *slot = position);
    waypoint
}
