//! The loads on the robot along a plan.

use surefoot_controller_sim::execution::simulation::Simulation;
use surefoot_shared_types::message::SimulationState;
use surefoot_shared_types::message::simulation_state::FootForce;

use crate::api::checker::Checker;
use crate::api::plan::{Foot, Plan};

/// The forces on the robot at an instant of a plan, as the controller's simulation computes them:
/// contact forces of least squares within the friction pyramids.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Time since the beginning of the plan, s.
    pub time: f64,
    /// Centre of mass in the world, m.
    pub centre_of_mass: [f64; 3],
    /// Distance of the centre of mass from the edge of the equilibrium region, m.
    pub balance_margin: f64,
    /// Largest share of the friction limit in use at a foot, 0 to 1.
    pub friction_use: f64,
    /// Largest share of the effort limit in use at a joint, 0 to 1.
    pub torque_use: f64,
    /// The stance feet.
    pub feet: Vec<FootLoad>,
    /// Efforts of the moving joints in the order of [`State::q`](crate::State::q), N m or N.
    pub torques: Vec<f64>,
}

/// The contact force on a foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// The foot.
    pub foot: Foot,
    /// Force of the ground on the foot in the world frame, N.
    pub force: [f64; 3],
    /// Centre of pressure in the world frame, m.
    pub centre: [f64; 3],
}

impl Checker {
    /// The loads along a plan that [`Checker::check_plan`] accepts: one every `tick` (s, positive)
    /// and one at the end.
    pub fn loads(&mut self, plan: &Plan, tick: f64) -> Vec<Load> {
        let mut simulation = Simulation::new(0, tick);
        let mut loads = vec![];
        for chunk in plan.chunks() {
            let joints = chunk.joints_len as usize;
            simulation.execute(self.segment_checker(), chunk, &mut |state| {
                loads.push(Load::new(state, joints));
            });
        }
        loads
    }
}

impl Load {
    fn new(state: &SimulationState, joints: usize) -> Self {
        let foot = |force: &FootForce| {
            let FootForce { limb, force, centre } = *force;
            Some(FootLoad { foot: Foot::of_limb(limb as u32)?, force, centre })
        };
        Self {
            time: state.waypoint.time,
            centre_of_mass: state.centre_of_mass,
            balance_margin: state.balance_margin,
            friction_use: state.friction_use,
            torque_use: state.torque_use,
            feet: state.feet[..state.feet_len as usize].iter().filter_map(foot).collect(),
            torques: state.torques[..joints].to_vec(),
        }
    }
}
