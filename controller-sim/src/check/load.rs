//! What the ground does to the feet and the motors do in one configuration, if the load is spread evenly.

use glam::DVec3;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::GRAVITY;

use super::equilibrium::{ALL_FRICTION, Equilibrium, Generator, balance};
use super::least_squares::least_squares;
use super::support::SoleSupport;
use crate::kinematics::Posture;

/// How a standing robot is loaded.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// The centre of mass in the world, m.
    pub centre_of_mass: DVec3,
    /// One per stance foot; none where no forces hold the robot.
    pub feet: Vec<FootLoad>,
    /// Joint torques, N m or N, locked joints after the moving ones.
    pub torques: Vec<f64>,
    /// The largest share of the friction that a contact point uses.
    pub friction_use: f64,
    /// The largest share of its effort limit that a joint uses.
    pub torque_use: f64,
}

/// The force of the ground on a foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// The foot.
    pub limb: usize,
    /// The force in the world, N.
    pub force: DVec3,
    /// Where its pressure is centred, m.
    pub centre: DVec3,
}

/// The load of least squares; without feet, and as if nothing but the root held the robot, where no forces hold it.
pub fn even_load(model: &RobotModel, equilibrium: &Equilibrium, supports: &[SoleSupport], posture: &Posture) -> Load {
    let centre_of_mass = posture.centre_of_mass(model);
    let generators = equilibrium.generators(supports, ALL_FRICTION);
    let forces = least_squares(&balance(&generators, centre_of_mass)).unwrap_or_default();
    let weight = model.mass() * GRAVITY;
    let pressed: Vec<(Generator, DVec3)> =
        generators.iter().zip(&forces).map(|(generator, force)| (*generator, force * weight * generator.force)).collect();
    let mut torques = posture.gravity_torques(model);
    for foot in supports {
        for joint in model.chain(model.feet[foot.limb].link) {
            let on_foot = pressed.iter().filter(|(generator, _)| generator.limb == foot.limb);
            torques[joint] -= on_foot.map(|(at, force)| posture.along_joint(model, joint, at.point, *force)).sum::<f64>();
        }
    }
    let share = model.joints.iter().zip(&torques).map(|(joint, torque)| torque.abs() / joint.effort);
    let torque_use = share.fold(0.0, f64::max);
    let feet = supports.iter().filter_map(|support| foot_load(support.limb, &pressed)).collect();
    let friction_use =
        supports.iter().flat_map(|s| &s.points).map(|point| friction_use(equilibrium.mu(), point.position, point.normal, &pressed));
    let friction_use = friction_use.fold(0.0, f64::max);
    Load { centre_of_mass, feet, torques, friction_use, torque_use }
}

fn foot_load(limb: usize, pressed: &[(Generator, DVec3)]) -> Option<FootLoad> {
    let on_foot = pressed.iter().filter(|(generator, _)| generator.limb == limb);
    let force: DVec3 = on_foot.clone().map(|(_, force)| *force).sum();
    let pressure: f64 = on_foot.clone().map(|(_, force)| force.length()).sum();
    let moment: DVec3 = on_foot.map(|(at, force)| at.point * force.length()).sum();
    (pressure > 0.0).then(|| FootLoad { limb, force, centre: moment / pressure })
}

/// How much of the friction cone the force at a contact point uses; 0 where it carries nothing.
fn friction_use(mu: f64, at: DVec3, normal: DVec3, pressed: &[(Generator, DVec3)]) -> f64 {
    let force: DVec3 = pressed.iter().filter(|(generator, _)| generator.point == at).map(|(_, force)| *force).sum();
    let across = force.dot(normal);
    if across > 0.0 { (force - across * normal).length() / (mu * across) } else { 0.0 }
}
