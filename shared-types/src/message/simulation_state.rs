//! The simulated robot's state, which a controller publishes at every tick.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::limits::{CONTACTS_MAX, JOINTS_MAX};
use crate::message::chunk::{SupportMode, Waypoint};
use crate::message::layout::layout;

/// The schema of [`SimulationState`].
pub const STATE_SCHEMA: u64 = 1;

/// The force of the ground on a foot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.FootForce.v1")]
pub struct FootForce {
    /// Which limb.
    pub limb: u64,
    /// The force, N, in the world.
    pub force: [f64; 3],
    /// Where its pressure is centred, m, in the world.
    pub centre: [f64; 3],
}

/// The simulated robot at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.SimulationState.v1")]
pub struct SimulationState {
    /// [`STATE_SCHEMA`].
    pub schema: u64,
    /// The controller's instance.
    pub controller_id: u64,
    /// The plan it walks.
    pub plan_id: u64,
    /// The epoch it walks.
    pub epoch: u64,
    /// The chunk it is in.
    pub sequence: u64,
    /// Counts this controller's ticks from 1, so that a listener knows whether it missed one.
    pub tick: u64,
    /// A `SupportMode` as its wire value.
    pub mode: u32,
    /// Feet in use.
    pub feet_len: u32,
    /// The configuration, and the plan's time.
    pub waypoint: Waypoint,
    /// The centre of mass in the world, m.
    pub centre_of_mass: [f64; 3],
    /// How far the centre of mass may still move before no contact forces hold the robot, m.
    pub balance_margin: f64,
    /// The largest share of its friction that a foot uses against sliding.
    pub friction_use: f64,
    /// The largest share of its effort limit that a joint uses.
    pub torque_use: f64,
    /// What the ground does to each stance foot.
    pub feet: [FootForce; CONTACTS_MAX],
    /// Torques of the moving joints, N m or N.
    pub torques: [f64; JOINTS_MAX],
}

const _: () = assert!(size_of::<FootForce>() == 56);
const _: () = assert!(
    size_of::<SimulationState>()
        == 104 + size_of::<Waypoint>() + CONTACTS_MAX * size_of::<FootForce>() + 8 * JOINTS_MAX
);

layout!(FootForce { limb: u64, force: [f64; 3], centre: [f64; 3] } with []);
layout!(SimulationState {
    schema: u64,
    controller_id: u64,
    plan_id: u64,
    epoch: u64,
    sequence: u64,
    tick: u64,
    mode: u32,
    feet_len: u32,
    waypoint: Waypoint,
    centre_of_mass: [f64; 3],
    balance_margin: f64,
    friction_use: f64,
    torque_use: f64,
    feet: [FootForce; CONTACTS_MAX],
    torques: [f64; JOINTS_MAX],
} with [Waypoint, FootForce]);

impl SimulationState {
    /// The feet in use.
    pub fn feet(&self) -> &[FootForce] {
        &self.feet[..(self.feet_len as usize).min(CONTACTS_MAX)]
    }

    /// Whether its numbers are in range.
    pub fn is_well_formed(&self) -> bool {
        let Self { waypoint, centre_of_mass, balance_margin, friction_use, torque_use, .. } = self;
        let pose =
            [waypoint.time].into_iter().chain(waypoint.root_position).chain(waypoint.root_rotation);
        let body = pose.chain(waypoint.q).chain(*centre_of_mass).chain([
            *balance_margin,
            *friction_use,
            *torque_use,
        ]);
        let forces = self.feet.iter().flat_map(|foot| foot.force.into_iter().chain(foot.centre));
        self.schema == STATE_SCHEMA
            && self.controller_id != 0
            && SupportMode::from_wire(self.mode).is_some()
            && self.feet_len as usize <= CONTACTS_MAX
            && body.chain(forces).chain(self.torques).all(f64::is_finite)
    }
}
