//! Foot forces and joint torques of a robot at an instant by the contact forces of least squares.

use glam::DVec3;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

use crate::base::comparison::largest;
use crate::kinematics::forward::Posture;
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium, Generator, balance};
use crate::statics::inverse_dynamics::InverseDynamics;
use crate::statics::joint_torques::Statics;
use crate::statics::least_squares::least_squares_forces;
use crate::statics::sole_support::{ContactPoint, SoleSupport};
use crate::statics::tuning::PYRAMID_SIDES;

/// Foot forces and joint torques of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLoad {
    /// The centre of mass in the world, m.
    pub centre_of_mass: DVec3,
    /// Distance that the centre of mass may move before no contact forces hold the robot, m.
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
    /// Its centre of pressure in the world, m.
    pub centre: DVec3,
    /// The moment about the centre of pressure, N m.
    pub moment: DVec3,
}

/// The force of the ground at one point.
struct PointForce {
    limb: usize,
    at: ContactPoint,
    force: DVec3,
}

impl PointForce {
    /// The part of the force that is not friction, N.
    fn pressure(&self) -> f64 {
        self.force.dot(self.at.normal)
    }
}

/// Sum of the ground's forces on one foot.
struct FootPressure {
    limb: usize,
    /// N.
    force: DVec3,
    /// The part of the forces along their points' normals, N.
    pressure: f64,
    /// The points, weighted by their pressure, N m.
    moment: DVec3,
    /// The mean normal.
    normal: DVec3,
    /// The moment of the forces about the world's origin, N m.
    about_origin: DVec3,
}

impl FootPressure {
    fn of_foot(limb: usize, point_forces: &[PointForce]) -> Self {
        let mut foot = Self {
            limb,
            force: DVec3::ZERO,
            pressure: 0.0,
            moment: DVec3::ZERO,
            normal: DVec3::ZERO,
            about_origin: DVec3::ZERO,
        };
        for point in point_forces.iter().filter(|point| point.limb == limb) {
            let pressure = point.pressure();
            foot.force += point.force;
            foot.pressure += pressure;
            foot.moment += pressure * point.at.position;
            foot.normal += pressure * point.at.normal;
            foot.about_origin += point.at.position.cross(point.force);
        }
        Self { normal: foot.normal.normalize_or_zero(), ..foot }
    }

    /// The share of the friction cone about the mean normal that the force uses.
    fn friction_use(&self, mu: f64) -> f64 {
        let along = self.force.dot(self.normal);
        if along > 0.0 { (self.force - along * self.normal).length() / (mu * along) } else { 0.0 }
    }

    fn load(&self) -> Option<FootLoad> {
        let centre = self.moment / self.pressure;
        (self.pressure > 0.0).then(|| FootLoad {
            limb: self.limb,
            force: self.force,
            centre,
            moment: self.about_origin - centre.cross(self.force),
        })
    }
}

/// The load of a robot at rest by contact forces of least squares. Where no forces hold the robot,
/// the load has no feet and the torques are those of a robot with a fixed root.
pub fn least_squares_load(
    model: &RobotModel,
    equilibrium: &mut Equilibrium,
    supports: &[SoleSupport],
    posture: &Posture,
) -> ContactLoad {
    let generators = equilibrium.generators(supports, ALL_FRICTION);
    let rows = balance(&generators, posture.centre_of_mass(model));
    let forces = least_squares_forces(&rows).unwrap_or_default();
    let stance = supports.iter().map(|support| support.limb).collect();
    let statics = Statics::new(model, generators.clone(), stance);
    let torques = statics.torques_under(posture, &forces);
    load_of((model, posture), equilibrium, supports, (&generators, &forces), torques)
}

/// The load of a robot that moves as `dynamics` says by contact forces of least squares. Where no
/// forces move the robot so, the load has no feet.
pub fn moving_load(
    (model, posture): (&RobotModel, &Posture),
    equilibrium: &mut Equilibrium,
    supports: &[SoleSupport],
    dynamics: &InverseDynamics,
) -> ContactLoad {
    let generators = equilibrium.generators(supports, ALL_FRICTION);
    let rows = dynamics.balance(model, &generators);
    let forces = least_squares_forces(&rows).unwrap_or_default();
    let torques = dynamics.torques_under(model, posture, (&generators, &forces));
    load_of((model, posture), equilibrium, supports, (&generators, &forces), torques)
}

/// The load under these forces: a share of the weight for each generator.
fn load_of(
    (model, posture): (&RobotModel, &Posture),
    equilibrium: &mut Equilibrium,
    supports: &[SoleSupport],
    (generators, forces): (&[Generator], &[f64]),
    torques: Vec<f64>,
) -> ContactLoad {
    let centre_of_mass = posture.centre_of_mass(model);
    let point_forces = point_forces(supports, generators, forces, model.mass() * GRAVITY);
    let pressures: Vec<FootPressure> =
        supports.iter().map(|support| FootPressure::of_foot(support.limb, &point_forces)).collect();
    let share =
        model.joints.iter().zip(&torques).map(|(joint, torque)| torque.abs() / joint.effort);
    ContactLoad {
        centre_of_mass,
        balance_margin: equilibrium.region(supports, ALL_FRICTION).margin(centre_of_mass),
        feet: pressures.iter().filter_map(FootPressure::load).collect(),
        torque_use: largest(share),
        torques,
        friction_use: largest(pressures.iter().map(|foot| foot.friction_use(equilibrium.mu()))),
    }
}

fn point_forces(
    supports: &[SoleSupport],
    generators: &[Generator],
    forces: &[f64],
    weight: f64,
) -> Vec<PointForce> {
    let points =
        supports.iter().flat_map(|support| support.points.iter().map(|&at| (support.limb, at)));
    let edges = generators.chunks(PYRAMID_SIDES).zip(forces.chunks(PYRAMID_SIDES));
    let force = |(edges, shares): (&[Generator], &[f64])| {
        edges.iter().zip(shares).map(|(edge, share)| share * weight * edge.force).sum()
    };
    points
        .zip(edges)
        .map(|((limb, at), edges)| PointForce { limb, at, force: force(edges) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::{ELBOW, SHOULDER, both_feet, robot, waypoint, world};
    use crate::kinematics::forward::Configuration;
    use crate::statics::sole_support::SupportFinder;

    struct Loaded {
        model: RobotModel,
        posture: Posture,
        load: ContactLoad,
    }

    /// The load of the robot with its arm so, which moves its elbow at an acceleration.
    fn loaded(shoulder: f64, acceleration: Option<f64>) -> Loaded {
        let (model, world) = (robot(), world(vec![]));
        let mut finder = SupportFinder::new(&model, &world, &Default::default()).unwrap();
        let supports = both_feet().map(|contact| finder.find(&contact, 1.0));
        let mut equilibrium = Equilibrium::new(world.mu);
        let mut at = waypoint(0.0, shoulder, 0.0);
        let posture = Posture::new(&model, &Configuration::of_waypoint(&at, 4));
        let load = match acceleration {
            None => least_squares_load(&model, &mut equilibrium, &supports, &posture),
            Some(acceleration) => {
                at.joint_acceleration[ELBOW] = acceleration;
                let dynamics = InverseDynamics::new(&model, &posture, &at);
                moving_load((&model, &posture), &mut equilibrium, &supports, &dynamics)
            }
        };
        Loaded { model, posture, load }
    }

    fn weight(model: &RobotModel) -> f64 {
        model.mass() * GRAVITY
    }

    /// The moment of all forces about a point.
    fn moment_about(load: &ContactLoad, point: DVec3) -> DVec3 {
        load.feet.iter().map(|foot| (foot.centre - point).cross(foot.force) + foot.moment).sum()
    }

    #[test]
    fn the_forces_on_the_feet_hold_the_weight_at_the_centre_of_mass() {
        let Loaded { model, load, .. } = loaded(-0.8, None);
        let force: DVec3 = load.feet.iter().map(|foot| foot.force).sum();
        assert!(force.distance(weight(&model) * DVec3::Z) < 1e-4, "{force}");
        assert!(moment_about(&load, load.centre_of_mass).length() < 1e-4);
        for foot in &load.feet {
            assert!(foot.force.z > 0.0 && foot.centre.z.abs() < 1e-9);
            // Pressure on a level floor has no moment about horizontal axes.
            assert!(foot.moment.truncate().length() < 1e-6, "{foot:?}");
            let beside = if foot.limb == 0 { foot.centre.y - 0.1 } else { foot.centre.y + 0.1 };
            assert!(foot.centre.x.abs() <= 0.1 && beside.abs() <= 0.05, "{foot:?}");
        }
        let needed = MASS_LEVER * GRAVITY * libm::sin(0.8);
        assert!((load.torques[SHOULDER].abs() - needed).abs() < 1e-6, "{:?}", load.torques);
        assert!(load.torque_use >= needed / 200.0);
        let largest = load.torques.iter().fold(0.0_f64, |most, torque| most.max(torque.abs()));
        assert!((load.torque_use - largest / 200.0).abs() < 1e-12);
        assert!(load.balance_margin > 0.05 && load.friction_use < 0.2, "{load:?}");
    }

    /// Two arm links of 2 kg, 0.2 and 0.6 m from the shoulder.
    const MASS_LEVER: f64 = 2.0 * (0.2 + 0.6);

    #[test]
    fn the_forces_on_the_feet_move_the_robot() {
        let acceleration = 2.0;
        let Loaded { model, posture, load } = loaded(0.0, Some(acceleration));
        // The forearm's centre, 0.2 m below the elbow, accelerates about x.
        let of_forearm = acceleration * DVec3::X.cross(DVec3::new(0.0, 0.0, -0.2));
        let change = model.links[4].mass * of_forearm;
        let force: DVec3 = load.feet.iter().map(|foot| foot.force).sum();
        let expected = weight(&model) * DVec3::Z + change;
        assert!(force.distance(expected) < 1e-4, "{force} {expected}");
        // About the forearm's centre, its inertia of 1 kg m2 takes the moment, and the weight of
        // all else.
        let forearm = posture.world_from_link[4] * model.links[4].com;
        let of_weight = (load.centre_of_mass - forearm).cross(-weight(&model) * DVec3::Z);
        let moment = moment_about(&load, forearm) + of_weight;
        assert!(moment.distance(acceleration * DVec3::X) < 1e-3, "{moment}");
        let still = loaded(0.0, Some(0.0)).load;
        assert!(still.friction_use < load.friction_use, "{still:?} {load:?}");
    }

    #[test]
    fn a_foot_uses_the_share_of_friction_by_which_its_force_leans() {
        let normal = DVec3::new(0.0, 0.6, 0.8);
        let force = 100.0 * normal + 20.0 * DVec3::X;
        let at = ContactPoint { position: DVec3::new(0.3, -0.2, 0.1), normal };
        let point = |limb: usize| PointForce { limb, at, force };
        let foot = FootPressure::of_foot(0, &[point(0), point(1), point(0)]);
        assert!((foot.pressure - 200.0).abs() < 1e-9 && foot.force.distance(2.0 * force) < 1e-9);
        assert!((foot.friction_use(0.5) - 0.4).abs() < 1e-12);
        let load = foot.load().unwrap();
        assert!(load.centre.distance(at.position) < 1e-12 && load.moment.length() < 1e-9);
        let pulled = PointForce { force: -force, ..point(0) };
        let lifted = FootPressure::of_foot(0, &[pulled]);
        assert_eq!(lifted.load(), None);
        assert_eq!(FootPressure::of_foot(2, &[point(0)]).load(), None);
    }
}
