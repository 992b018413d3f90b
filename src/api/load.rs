//! The loads on the robot along a plan.

use surefoot_controller_sim::execution::simulation::Simulation;
use surefoot_controller_sim::statics::{self, ContactLoad};

use crate::api::checker::Checker;
use crate::api::plan::{Foot, Plan};

/// The forces on the robot at an instant of a plan, as the controller's simulation computes them:
/// contact forces of least squares within the friction pyramids, of a smooth plan by inverse
/// dynamics.
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
    /// Moment about the centre of pressure in the world frame, N m: with `force` and `centre` the
    /// whole wrench.
    pub moment: [f64; 3],
}

impl Checker {
    /// The loads along a plan that [`Checker::check_plan`] accepts: one every `tick` (s) and one at
    /// the end.
    ///
    /// # Panics
    /// `tick` is not positive.
    pub fn loads(&mut self, plan: &Plan, tick: f64) -> Vec<Load> {
        assert!(tick > 0.0, "a tick of {tick} s; it must be positive");
        let mut simulation = Simulation::new(0, tick);
        let mut loads = vec![];
        for chunk in plan.chunks() {
            let joints = chunk.joints_len as usize;
            for time in simulation.instants(chunk) {
                let (waypoint, load) = simulation.load_at(self.segment_checker(), chunk, time);
                loads.push(Load::new(waypoint.time, &load, joints));
            }
        }
        loads
    }

    /// The load at time `t` (s), clamped to the duration, of a plan that [`Checker::check_plan`]
    /// accepts: what [`Plan::sample`] gives beside it is the motion.
    pub fn load(&mut self, plan: &Plan, t: f64) -> Load {
        let chunk = plan.chunk_at(t);
        let mut simulation = Simulation::new(0, 1.0);
        let time = t.max(chunk.waypoints()[0].time).min(plan.duration());
        let (_, load) = simulation.load_at(self.segment_checker(), chunk, time);
        Load::new(time, &load, chunk.joints_len as usize)
    }
}

impl Load {
    fn new(time: f64, load: &ContactLoad, joints: usize) -> Self {
        let foot = |foot: &statics::FootLoad| {
            Some(FootLoad {
                foot: Foot::of_limb(foot.limb as u32)?,
                force: foot.force.to_array(),
                centre: foot.centre.to_array(),
                moment: foot.moment.to_array(),
            })
        };
        Self {
            time,
            centre_of_mass: load.centre_of_mass.to_array(),
            balance_margin: load.balance_margin,
            friction_use: load.friction_use,
            torque_use: load.torque_use,
            feet: load.feet.iter().filter_map(foot).collect(),
            torques: load.torques[..joints].to_vec(),
        }
    }
}
