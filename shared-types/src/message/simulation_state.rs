//! The state of the simulated robot, published at every tick.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::limits::{CONTACTS_MAX, JOINTS_MAX};
use crate::message::chunk::{SupportMode, Waypoint};
use crate::message::layout::layout;

/// The layout version in [`SimulationState::schema`].
pub const STATE_SCHEMA: u64 = 1;

/// The contact force on a foot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.FootForce.v1")]
pub struct FootForce {
    /// Index of the foot in `RobotModel::feet`.
    pub limb: u64,
    /// Force of the ground on the foot in the world frame, N.
    pub force: [f64; 3],
    /// Centre of pressure in the world frame, m.
    pub centre: [f64; 3],
}

/// The state of the simulated robot at one tick.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.SimulationState.v1")]
pub struct SimulationState {
    /// [`STATE_SCHEMA`].
    pub schema: u64,
    /// The controller's id.
    pub controller_id: u64,
    /// The plan that it executes.
    pub plan_id: u64,
    /// The epoch that it executes.
    pub epoch: u64,
    /// Sequence number of the chunk that it executes.
    pub sequence: u64,
    /// Number of this controller's tick, from 1; a gap shows a missed message.
    pub tick: u64,
    /// A [`SupportMode`] as its wire value.
    pub mode: u32,
    /// Number of used entries of `feet`.
    pub feet_len: u32,
    /// The configuration and the time of the plan.
    pub waypoint: Waypoint,
    /// Centre of mass in the world frame, m.
    pub centre_of_mass: [f64; 3],
    /// Distance of the centre of mass from the edge of the equilibrium region, m.
    pub balance_margin: f64,
    /// Largest share of the friction limit in use at a foot, 0 to 1.
    pub friction_use: f64,
    /// Largest share of the effort limit in use at a joint, 0 to 1.
    pub torque_use: f64,
    /// Contact forces of the stance feet.
    pub feet: [FootForce; CONTACTS_MAX],
    /// Efforts of the moving joints, N m or N.
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
    /// The used entries of `feet`.
    pub fn feet(&self) -> &[FootForce] {
        &self.feet[..(self.feet_len as usize).min(CONTACTS_MAX)]
    }

    /// Whether the schema, the counts and the mode are valid and all numbers are finite.
    pub fn is_well_formed(&self) -> bool {
        let Self { waypoint, centre_of_mass, balance_margin, friction_use, torque_use, .. } = self;
        let pose =
            [waypoint.time].into_iter().chain(waypoint.root_position).chain(waypoint.root_rotation);
        let body = pose.chain(waypoint.q).chain(waypoint.rates()).chain(*centre_of_mass).chain([
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
