//! Static joint torques of a configuration.
//!
//! On one foot the contact wrench is known: it carries the weight through the centre of mass. On
//! two feet the forces minimise the largest share of a joint's effort limit.

use glam::DVec3;
use surefoot_shared_types::robot::model::{Foot, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

use crate::base::comparison::is_at_most;
use crate::kinematics::forward::{Posture, along_axis};
use crate::statics::equilibrium::{Generator, MinimaxEffort, balance, dot};
use crate::statics::least_squares::least_squares_forces;

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
        let carries = |foot: &Foot| {
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
    /// `centre_of_mass` is that of `posture`, in the world, m. Torques above `share_max` of a limit
    /// are returned only where simplex and interior point agree.
    pub fn torques(
        &self,
        posture: &Posture,
        centre_of_mass: DVec3,
        share_max: f64,
    ) -> Option<Vec<f64>> {
        match self.stance[..] {
            [limb] => Some(posture.standing_torques(self.model, limb)),
            _ => self.on_several_feet(posture, centre_of_mass, share_max),
        }
    }

    fn on_several_feet(
        &self,
        posture: &Posture,
        centre_of_mass: DVec3,
        share_max: f64,
    ) -> Option<Vec<f64>> {
        let loads = JointLoads::new(self, posture);
        let share = |(&joint, generator_torques): (&usize, &Vec<f64>)| {
            let effort = self.model.joints[joint].effort;
            (
                generator_torques.iter().map(|value| -value / effort).collect::<Vec<f64>>(),
                loads.free[joint] / effort,
            )
        };
        let shares = loads.loaded.iter().zip(&loads.generator_torques).map(share).collect();
        let program = MinimaxEffort::new(&self.generators, centre_of_mass, shares);
        let fits = |torques: &Vec<f64>| {
            loads.loaded.iter().all(|&joint| {
                is_at_most(torques[joint].abs(), share_max * self.model.joints[joint].effort)
            })
        };
        let by_simplex = program.by_simplex().map(|forces| loads.torques(&forces)).filter(fits);
        by_simplex.or_else(|| program.by_interior_point().map(|forces| loads.torques(&forces)))
    }

    /// As [`Self::torques`], by forces of least squares.
    pub fn least_squares_torques(
        &self,
        posture: &Posture,
        centre_of_mass: DVec3,
    ) -> Option<Vec<f64>> {
        let forces = least_squares_forces(&balance(&self.generators, centre_of_mass))?;
        Some(self.torques_under(posture, &forces))
    }

    /// All joint torques (N m) or forces (N) under these contact forces: a share of the weight for
    /// each generator, or no forces at all.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::{randoms, robot, waypoint};
    use crate::kinematics::forward::Configuration;
    use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium};
    use crate::statics::inverse_dynamics::InverseDynamics;
    use crate::statics::sole_support::level_soles;

    /// The robot at rest in a stride with its arm so, and weak hips of different strengths.
    struct Resting {
        model: RobotModel,
        posture: Posture,
        dynamics: InverseDynamics,
        generators: Vec<Generator>,
    }

    fn resting(shoulder: f64, elbow: f64) -> Resting {
        let mut model = robot();
        (model.joints[0].effort, model.joints[1].effort) = (31.0, 57.0);
        let mut at = waypoint(0.0, shoulder, elbow);
        at.q[..2].copy_from_slice(&[0.4, -0.2]);
        let posture = Posture::new(&model, &Configuration::of_waypoint(&at, 4));
        let dynamics = InverseDynamics::new(&model, &posture, &at);
        let supports = level_soles(&model, &posture);
        let generators = Equilibrium::new(0.6).generators(&supports, ALL_FRICTION);
        Resting { model, posture, dynamics, generators }
    }

    fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
        let pairs = found.iter().zip(expected);
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.len() == expected.len() && apart < tolerance, "{found:?} {expected:?}");
    }

    #[test]
    fn torques_under_forces_are_those_of_a_robot_that_does_not_move() {
        let mut random = randoms(1);
        for _ in 0..10 {
            let Resting { model, posture, dynamics, generators } =
                resting(random(-1.0, 1.0), random(-1.0, 1.0));
            let forces: Vec<f64> = generators.iter().map(|_| random(0.0, 0.1)).collect();
            let expected = dynamics.torques_under(&model, &posture, (&generators, &forces));
            let statics = Statics::new(&model, generators, vec![0, 1]);
            assert_near(&statics.torques_under(&posture, &forces), &expected, 1e-9);
        }
    }

    #[test]
    fn the_least_torques_are_those_of_a_robot_that_does_not_move() {
        for (shoulder, share_max) in [(0.7, 0.95), (-0.9, 0.95), (0.7, 1e-6)] {
            let Resting { model, posture, dynamics, generators } = resting(shoulder, 0.3);
            let expected = dynamics.torques(&model, &posture, &generators, share_max).unwrap();
            let centre_of_mass = posture.centre_of_mass(&model);
            let statics = Statics::new(&model, generators, vec![0, 1]);
            let found = statics.torques(&posture, centre_of_mass, share_max).unwrap();
            assert_near(&found, &expected, 1e-3);
            // The hips share the load by their strengths.
            assert!((found[0] / 31.0 - found[1] / 57.0).abs() < 1e-4, "{found:?}");
            assert!(found[0].abs() > 1.0, "{found:?}");
            let beside = centre_of_mass + DVec3::X;
            assert_eq!(statics.torques(&posture, beside, share_max), None);
        }
    }

    #[test]
    fn on_one_foot_the_torques_follow_from_the_weight_alone() {
        for limb in [0, 1] {
            let Resting { model, posture, generators, .. } = resting(0.5, 0.2);
            let centre = posture.centre_of_mass(&model);
            let generators = generators.into_iter().filter(|edge| edge.limb == limb).collect();
            let statics = Statics::new(&model, generators, vec![limb]);
            let found = statics.torques(&posture, centre, 0.95).unwrap();
            // The hip carries all but its leg, the other hip its leg.
            let hip = posture.world_from_link[1 + limb].translation;
            let moment = |mass: f64, at: DVec3| mass * GRAVITY * (at - hip).cross(DVec3::Z).y;
            let weight = moment(model.mass(), centre);
            let [of_leg, of_other] = [limb, 1 - limb].map(|limb| {
                let (link, pose) = (&model.links[1 + limb], &posture.world_from_link[1 + limb]);
                moment(link.mass, *pose * link.com)
            });
            assert!((found[limb] - (of_leg - weight)).abs() < 1e-9, "{found:?}");
            // Both hips are on one line.
            assert!((found[1 - limb] - of_other).abs() < 1e-9, "{found:?}");
        }
    }
}
