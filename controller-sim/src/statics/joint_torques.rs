//! Static joint torques within the effort limits.
//!
//! On one foot the contact wrench is known: it carries the weight through the centre of mass. On
//! two, the forces are those that load the most loaded joint least.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

use crate::base::comparison::is_at_most;
use crate::check::checker::{Case, Violation};
use crate::check::motion::Sample;
use crate::kinematics::forward::{Posture, along_axis};
use crate::statics::equilibrium::{
    ALL_FRICTION, Equilibrium, Generator, MinimaxEffort, balance, dot,
};
use crate::statics::least_squares::least_squares_forces;

/// Rounding allowed at a limit, as a share of it.
const ROUNDING: f64 = 1e-6;
/// Between waypoints every so many samples are checked: no joint turns by more than 0.05 rad from
/// one to the next.
const SAMPLES_APART: usize = 5;

/// The share of a joint's effort limit that stays unused at the worst waypoint, or between two that
/// are far apart. `heartbeat` is called at each.
pub fn check_torque(
    model: &RobotModel,
    config: &CheckerConfig,
    equilibrium: &mut Equilibrium,
    case: &Case,
    heartbeat: &mut dyn FnMut(),
) -> Result<f64, Violation> {
    let statics =
        Statics::new(model, equilibrium.generators(&case.supports, ALL_FRICTION), stance_of(case));
    let mut worst = f64::INFINITY;
    for sample in
        case.motion.samples.iter().filter(|sample| sample.substep.is_multiple_of(SAMPLES_APART))
    {
        heartbeat();
        let bad = |detail| Err(Violation::new(Check::Torque, sample.waypoint, detail));
        let Some(torques) = statics.torques(sample, config.effort_share + ROUNDING) else {
            return bad("no contact forces in equilibrium".to_owned());
        };
        for (joint, torque) in model.joints.iter().zip(torques) {
            let share = torque.abs() / joint.effort;
            if !is_at_most(share, config.effort_share + ROUNDING) {
                let limit = config.effort_share * joint.effort;
                return bad(format!(
                    "joint {} needs {:.1} N m or N, limit {limit:.1}",
                    joint.name,
                    torque.abs()
                ));
            }
            worst = worst.min(1.0 - share);
        }
    }
    Ok(worst)
}

/// As [`check_torque`], by contact forces of least squares instead of those that minimise the
/// largest torque share. It has no limit. Minus infinity where no such forces hold the robot.
pub fn least_squares_torque_reserve(
    model: &RobotModel,
    equilibrium: &Equilibrium,
    case: &Case,
) -> f64 {
    let statics =
        Statics::new(model, equilibrium.generators(&case.supports, ALL_FRICTION), stance_of(case));
    let reserve = |sample: &Sample| {
        let Some(torques) = statics.least_squares_torques(sample) else { return f64::NEG_INFINITY };
        let shares =
            model.joints.iter().zip(torques).map(|(joint, torque)| torque.abs() / joint.effort);
        1.0 - shares.fold(0.0, f64::max)
    };
    case.motion
        .samples
        .iter()
        .filter(|sample| sample.is_waypoint())
        .map(reserve)
        .fold(f64::INFINITY, f64::min)
}

fn stance_of(case: &Case) -> Vec<usize> {
    case.contacts.iter().map(|contact| contact.limb as usize).collect()
}

/// Data shared by all configurations on the same contacts.
pub struct Statics<'a> {
    model: &'a RobotModel,
    weight: f64,
    generators: Vec<Generator>,
    /// Per foot, whether each joint lies between the root and it.
    carries: Vec<Vec<bool>>,
    stance: Vec<usize>,
}

impl<'a> Statics<'a> {
    /// For a robot on the feet of `stance`, which these forces may hold.
    pub fn new(model: &'a RobotModel, generators: Vec<Generator>, stance: Vec<usize>) -> Self {
        let carries = |foot: &surefoot_shared_types::robot::model::Foot| {
            let chain = model.chain(foot.link);
            (0..model.joints.len()).map(|joint| chain.contains(&joint)).collect()
        };
        Self {
            model,
            weight: model.mass() * GRAVITY,
            generators,
            carries: model.feet.iter().map(carries).collect(),
            stance,
        }
    }

    /// All joint torques (N m) or forces (N), or nothing where no contact forces hold the robot.
    /// Torques above `share_max` of a limit are given only where both methods agree.
    fn torques(&self, sample: &Sample, share_max: f64) -> Option<Vec<f64>> {
        match self.stance[..] {
            [limb] => Some(sample.posture.standing_torques(self.model, limb)),
            _ => self.on_several_feet(sample, share_max),
        }
    }

    fn on_several_feet(&self, sample: &Sample, share_max: f64) -> Option<Vec<f64>> {
        let loads = JointLoads::new(self, &sample.posture);
        let share = |(&joint, generator_torques): (&usize, &Vec<f64>)| {
            let effort = self.model.joints[joint].effort;
            (
                generator_torques.iter().map(|value| -value / effort).collect::<Vec<f64>>(),
                loads.free[joint] / effort,
            )
        };
        let shares = loads.loaded.iter().zip(&loads.generator_torques).map(share).collect();
        let program = MinimaxEffort::new(&self.generators, sample.centre_of_mass, shares);
        let fits = |torques: &Vec<f64>| {
            loads.loaded.iter().all(|&joint| {
                is_at_most(torques[joint].abs(), share_max * self.model.joints[joint].effort)
            })
        };
        let by_simplex = program.by_simplex().map(|forces| loads.torques(&forces)).filter(fits);
        by_simplex.or_else(|| program.by_interior_point().map(|forces| loads.torques(&forces)))
    }

    /// As [`Self::torques`], by forces of least squares.
    fn least_squares_torques(&self, sample: &Sample) -> Option<Vec<f64>> {
        let forces = least_squares_forces(&balance(&self.generators, sample.centre_of_mass))?;
        Some(self.torques_under(&sample.posture, &forces))
    }

    /// All joint torques (N m) or forces (N) where the ground presses so: a weight's share for each
    /// of the generators, or none.
    pub fn torques_under(&self, posture: &Posture, forces: &[f64]) -> Vec<f64> {
        JointLoads::new(self, posture).torques(forces)
    }

    /// By how much one unit of each generator reduces a joint's torque.
    fn generator_torques(&self, posture: &Posture, joint: usize) -> Vec<f64> {
        let (kind, (axis, origin)) =
            (self.model.joints[joint].kind, posture.joint_axis(self.model, joint));
        let taken = |generator: &Generator| {
            let force = self.weight * generator.force;
            if self.carries[generator.limb][joint] {
                along_axis(kind, (axis, origin), generator.point, force)
            } else {
                0.0
            }
        };
        self.generators.iter().map(taken).collect()
    }
}

/// Joint torques in one configuration.
struct JointLoads {
    /// Their torques if nothing but the root held the robot.
    free: Vec<f64>,
    /// The joints between the root and a stance foot.
    loaded: Vec<usize>,
    /// By how much one unit of each generator reduces each of their torques.
    generator_torques: Vec<Vec<f64>>,
}

impl JointLoads {
    fn new(statics: &Statics, posture: &Posture) -> Self {
        let free = posture.gravity_torques(statics.model);
        let carries =
            |joint: &usize| statics.stance.iter().any(|&limb| statics.carries[limb][*joint]);
        let loaded: Vec<usize> = (0..free.len()).filter(carries).collect();
        let generator_torques =
            loaded.iter().map(|&joint| statics.generator_torques(posture, joint)).collect();
        Self { free, loaded, generator_torques }
    }

    fn torques(&self, forces: &[f64]) -> Vec<f64> {
        let mut torques = self.free.clone();
        for (&joint, generator_torques) in self.loaded.iter().zip(&self.generator_torques) {
            torques[joint] -= dot(generator_torques, forces);
        }
        torques
    }
}
