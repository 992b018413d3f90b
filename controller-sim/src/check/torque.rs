//! Static joint torques within the effort limits.
//!
//! On one foot the contact wrench is known: it carries the weight through the centre of mass. On two, the forces are those
//! that load the most loaded joint least.

use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::GRAVITY;

use super::equilibrium::{Equilibrium, Generator, LeastEffort};
use super::motion::Sample;
use super::{Case, Violation};
use crate::bound::within;
use crate::kinematics::along_axis;

/// Rounding allowed at a limit, as a share of it.
const ROUNDING: f64 = 1e-6;

/// The share of a joint's effort limit that stays unused at the worst waypoint.
pub fn check_torque(model: &RobotModel, config: &CheckerConfig, equilibrium: &mut Equilibrium, case: &Case) -> Result<f64, Violation> {
    let statics = Statics::new(model, equilibrium.generators(&case.supports), case);
    let mut worst = f64::INFINITY;
    for sample in case.motion.samples.iter().filter(|sample| sample.is_waypoint) {
        let bad = |detail| Err(Violation::new(Check::Torque, sample.waypoint, detail));
        let Some(torques) = statics.torques(sample, config.effort_share + ROUNDING) else {
            return bad("no contact forces in equilibrium".to_owned());
        };
        for (joint, torque) in model.joints.iter().zip(torques) {
            let share = torque.abs() / joint.effort;
            if !within(share, config.effort_share + ROUNDING) {
                let limit = config.effort_share * joint.effort;
                return bad(format!("joint {} needs {:.1} N m or N, limit {limit:.1}", joint.name, torque.abs()));
            }
            worst = worst.min(1.0 - share);
        }
    }
    Ok(worst)
}

/// What is the same for all samples of a segment.
struct Statics<'a> {
    model: &'a RobotModel,
    weight: f64,
    generators: Vec<Generator>,
    /// Per foot, whether each joint lies between the root and it.
    carries: Vec<Vec<bool>>,
    stance: Vec<usize>,
}

impl<'a> Statics<'a> {
    fn new(model: &'a RobotModel, generators: Vec<Generator>, case: &Case) -> Self {
        let carries = |foot: &surefoot_shared_types::robot::Foot| {
            let chain = model.chain(foot.link);
            (0..model.joints.len()).map(|joint| chain.contains(&joint)).collect()
        };
        Self {
            model,
            weight: model.mass() * GRAVITY,
            generators,
            carries: model.feet.iter().map(carries).collect(),
            stance: case.contacts.iter().map(|contact| contact.limb as usize).collect(),
        }
    }

    /// All joint torques (N m) or forces (N), or nothing where no contact forces hold the robot. Torques above `share_max`
    /// of a limit are given only where both methods agree.
    fn torques(&self, sample: &Sample, share_max: f64) -> Option<Vec<f64>> {
        match self.stance[..] {
            [limb] => Some(sample.posture.standing_torques(self.model, limb)),
            _ => self.on_several_feet(sample, share_max),
        }
    }

    fn on_several_feet(&self, sample: &Sample, share_max: f64) -> Option<Vec<f64>> {
        let free = sample.posture.gravity_torques(self.model);
        let loaded: Vec<usize> = (0..free.len()).filter(|&joint| self.stance.iter().any(|&limb| self.carries[limb][joint])).collect();
        let relief: Vec<Vec<f64>> = loaded.iter().map(|&joint| self.relief(sample, joint)).collect();
        let share = |(&joint, relief): (&usize, &Vec<f64>)| {
            let effort = self.model.joints[joint].effort;
            (relief.iter().map(|value| -value / effort).collect::<Vec<f64>>(), free[joint] / effort)
        };
        let shares = loaded.iter().zip(&relief).map(share).collect();
        let program = LeastEffort::new(&self.generators, sample.centre_of_mass, shares);
        let torques = |forces: Vec<f64>| {
            let mut torques = free.clone();
            for (&joint, relief) in loaded.iter().zip(&relief) {
                torques[joint] -= relief.iter().zip(&forces).map(|(a, b)| a * b).sum::<f64>();
            }
            torques
        };
        let fits =
            |torques: &Vec<f64>| loaded.iter().all(|&joint| within(torques[joint].abs(), share_max * self.model.joints[joint].effort));
        program.quickly().map(torques).filter(fits).or_else(|| program.thoroughly().map(torques))
    }

    /// What one unit of each generator takes off a joint.
    fn relief(&self, sample: &Sample, joint: usize) -> Vec<f64> {
        let (kind, (axis, origin)) = (self.model.joints[joint].kind, sample.posture.joint_axis(self.model, joint));
        let taken = |generator: &Generator| {
            let force = self.weight * generator.force;
            if self.carries[generator.limb][joint] { along_axis(kind, (axis, origin), generator.point, force) } else { 0.0 }
        };
        self.generators.iter().map(taken).collect()
    }
}
