//! What the ground does to the feet and the motors do in one configuration, if the load is spread evenly.

use glam::DVec3;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::GRAVITY;

use super::equilibrium::{ALL_FRICTION, Equilibrium, Generator, PYRAMID_SIDES, balance};
use super::least_squares::even_forces;
use super::support::{ContactPoint, SoleSupport};
use crate::kinematics::Posture;

/// How a standing robot is loaded.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// The centre of mass in the world, m.
    pub centre_of_mass: DVec3,
    /// How far it may still move before no contact forces hold the robot, m.
    pub balance_margin: f64,
    /// One per stance foot; none where no forces hold the robot.
    pub feet: Vec<FootLoad>,
    /// Joint torques, N m or N, locked joints after the moving ones.
    pub torques: Vec<f64>,
    /// The largest share of its friction that a foot uses against sliding.
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

/// The force of the ground at one point.
struct Pressed {
    limb: usize,
    at: ContactPoint,
    force: DVec3,
}

impl Pressed {
    /// The part of the force that is not friction, N.
    fn pressure(&self) -> f64 {
        self.force.dot(self.at.normal)
    }
}

/// The load of least squares; without feet, and as if nothing but the root held the robot, where no forces hold it.
pub fn even_load(model: &RobotModel, equilibrium: &mut Equilibrium, supports: &[SoleSupport], posture: &Posture) -> Load {
    let centre_of_mass = posture.centre_of_mass(model);
    let generators = equilibrium.generators(supports, ALL_FRICTION);
    let forces = even_forces(&balance(&generators, centre_of_mass)).unwrap_or_default();
    let pressed = pressed(supports, &generators, &forces, model.mass() * GRAVITY);
    let torques = torques(model, &pressed, posture);
    let share = model.joints.iter().zip(&torques).map(|(joint, torque)| torque.abs() / joint.effort);
    Load {
        centre_of_mass,
        balance_margin: equilibrium.region(supports, ALL_FRICTION).margin(centre_of_mass),
        feet: supports.iter().filter_map(|support| foot_load(support.limb, &pressed)).collect(),
        torque_use: share.fold(0.0, f64::max),
        torques,
        friction_use: supports.iter().map(|support| friction_use(equilibrium.mu(), support.limb, &pressed)).fold(0.0, f64::max),
    }
}

fn pressed(supports: &[SoleSupport], generators: &[Generator], forces: &[f64], weight: f64) -> Vec<Pressed> {
    let points = supports.iter().flat_map(|support| support.points.iter().map(|&at| (support.limb, at)));
    let edges = generators.chunks(PYRAMID_SIDES).zip(forces.chunks(PYRAMID_SIDES));
    let force = |(edges, shares): (&[Generator], &[f64])| edges.iter().zip(shares).map(|(edge, share)| share * weight * edge.force).sum();
    points.zip(edges).map(|((limb, at), edges)| Pressed { limb, at, force: force(edges) }).collect()
}

fn torques(model: &RobotModel, pressed: &[Pressed], posture: &Posture) -> Vec<f64> {
    let mut torques = posture.gravity_torques(model);
    for (limb, foot) in model.feet.iter().enumerate() {
        for joint in model.chain(foot.link) {
            let on_foot = pressed.iter().filter(|point| point.limb == limb);
            torques[joint] -= on_foot.map(|point| posture.along_joint(model, joint, point.at.position, point.force)).sum::<f64>();
        }
    }
    torques
}

/// How much of the friction cone about its mean normal a foot's force uses.
fn friction_use(mu: f64, limb: usize, pressed: &[Pressed]) -> f64 {
    let on_foot = pressed.iter().filter(|point| point.limb == limb);
    let force: DVec3 = on_foot.clone().map(|point| point.force).sum();
    let normal = on_foot.map(|point| point.pressure() * point.at.normal).sum::<DVec3>().normalize_or_zero();
    let pressure = force.dot(normal);
    if pressure > 0.0 { (force - pressure * normal).length() / (mu * pressure) } else { 0.0 }
}

fn foot_load(limb: usize, pressed: &[Pressed]) -> Option<FootLoad> {
    let on_foot = pressed.iter().filter(|point| point.limb == limb);
    let force: DVec3 = on_foot.clone().map(|point| point.force).sum();
    let pressure: f64 = on_foot.clone().map(Pressed::pressure).sum();
    let moment: DVec3 = on_foot.map(|point| point.at.position * point.pressure()).sum();
    (pressure > 0.0).then(|| FootLoad { limb, force, centre: moment / pressure })
}
