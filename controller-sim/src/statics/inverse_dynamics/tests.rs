//! Links as clouds of point masses: by d'Alembert's principle their accelerations, measured by
//! differences of positions, give the wrench of the contacts and, by virtual work, the torques.

use glam::{DMat3, DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;

use super::*;
use crate::check_robot::{randoms, robot, waypoint};
use crate::kinematics::forward::Configuration;
use crate::statics::equilibrium::{ALL_FRICTION, Equilibrium};
use crate::statics::simplex::Simplex;
use crate::statics::sole_support::level_soles;

/// Time and joint steps of the differences, s and rad or m.
const STEP: f64 = 1e-3;
/// Largest difference of a force (N) or torque (N m), of some hundreds.
const TOLERANCE: f64 = 5e-3;

/// A robot of random proportions and motion: its links are points with masses.
struct Case {
    model: RobotModel,
    points: Vec<Vec<(DVec3, f64)>>,
    at: Waypoint,
}

type Random<'a> = &'a mut dyn FnMut(f64, f64) -> f64;

fn vector(random: Random) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| random(-1.0, 1.0)))
}

/// Mass, centre and inertia about the centre of some points.
fn body_of(points: &[(DVec3, f64)]) -> (f64, DVec3, DMat3) {
    let mass: f64 = points.iter().map(|(_, mass)| mass).sum();
    let centre = points.iter().map(|(at, mass)| *mass * *at).sum::<DVec3>() / mass;
    let inertia = |(at, mass): &(DVec3, f64)| {
        let arm = *at - centre;
        let outer = DMat3::from_cols(arm.x * arm, arm.y * arm, arm.z * arm);
        *mass * (arm.length_squared() * DMat3::IDENTITY - outer)
    };
    (mass, centre, points.iter().map(inertia).fold(DMat3::ZERO, |sum, part| sum + part))
}

impl Case {
    fn new(seed: u64) -> Self {
        let random = &mut randoms(seed);
        let mut model = robot();
        let points: Vec<Vec<(DVec3, f64)>> = (0..model.links.len())
            .map(|_| (0..5).map(|_| (0.3 * vector(random), random(0.5, 3.0))).collect())
            .collect();
        for (link, points) in model.links.iter_mut().zip(&points) {
            (link.mass, link.com, link.inertia) = body_of(points);
            if let Some(attachment) = &mut link.parent {
                let rotation = rotation_from_scaled_axis(vector(random));
                attachment.parent_from_joint = Pose::from_parts(0.5 * vector(random), rotation);
            }
        }
        for (index, joint) in model.joints.iter_mut().enumerate() {
            joint.axis = vector(random).normalize();
            let slides = (index as u64 + seed).is_multiple_of(3);
            joint.kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
        }
        let mut at = waypoint(0.0, 0.0, 0.0);
        let root = rotation_from_scaled_axis(vector(random));
        at.root_position = (0.7 * vector(random)).to_array();
        at.root_rotation = root.to_array();
        let joints = model.joints.len();
        for numbers in [&mut at.q, &mut at.joint_velocity, &mut at.joint_acceleration] {
            numbers[..joints].iter_mut().for_each(|number| *number = random(-1.5, 1.5));
        }
        for numbers in [&mut at.root_velocity, &mut at.root_acceleration] {
            numbers.iter_mut().for_each(|number| *number = random(-1.5, 1.5));
        }
        Self { model, points, at }
    }

    /// The configuration after a time, with constant accelerations.
    fn configuration(&self, time: f64) -> Configuration {
        let moved = |velocity: &[f64], acceleration: &[f64]| -> Vec<f64> {
            let pairs = velocity.iter().zip(acceleration);
            pairs.map(|(v, a)| v * time + 0.5 * a * time * time).collect()
        };
        let root = moved(&self.at.root_velocity, &self.at.root_acceleration);
        let [offset, turn] = [&root[..3], &root[3..]].map(DVec3::from_slice);
        let rotation = DQuat::from_array(self.at.root_rotation);
        let joints = moved(&self.at.joint_velocity, &self.at.joint_acceleration);
        Configuration {
            world_from_root: Pose::from_parts(
                DVec3::from_array(self.at.root_position) + offset,
                rotation_from_scaled_axis(turn) * rotation,
            ),
            q: self
                .model
                .joints
                .iter()
                .zip(self.at.q.iter().zip(joints))
                .map(|(_, (q, moved))| q + moved)
                .collect(),
        }
    }

    fn posture(&self, configuration: &Configuration) -> Posture {
        Posture::new(&self.model, configuration)
    }

    /// All points in the world, link by link.
    fn places(&self, configuration: &Configuration) -> Vec<DVec3> {
        let posture = self.posture(configuration);
        let links = posture.world_from_link.iter().zip(&self.points);
        links.flat_map(|(pose, points)| points.iter().map(|(at, _)| *pose * *at)).collect()
    }

    /// For each point, where it is and the force that moves it and carries its weight.
    fn forces(&self) -> Vec<(DVec3, DVec3)> {
        let [before, now, after] =
            [-STEP, 0.0, STEP].map(|time| self.places(&self.configuration(time)));
        let masses = self.points.iter().flatten().map(|(_, mass)| *mass);
        let force = |(index, mass): (usize, f64)| {
            let acceleration = (after[index] - 2.0 * now[index] + before[index]) / (STEP * STEP);
            (now[index], mass * (acceleration + GRAVITY * DVec3::Z))
        };
        masses.enumerate().map(force).collect()
    }

    /// By how much each place moves with a joint.
    fn slopes(&self, joint: usize, places: impl Fn(&Configuration) -> Vec<DVec3>) -> Vec<DVec3> {
        let moved = |change: f64| {
            let mut configuration = self.configuration(0.0);
            configuration.q[joint] += change;
            places(&configuration)
        };
        let (before, after) = (moved(-STEP), moved(STEP));
        after.iter().zip(&before).map(|(a, b)| (*a - *b) / (2.0 * STEP)).collect()
    }

    /// The joint torques without contact forces, by virtual work.
    fn free_torques(&self) -> Vec<f64> {
        let forces = self.forces();
        let work = |joint: usize| -> f64 {
            let slopes = self.slopes(joint, |configuration| self.places(configuration));
            slopes.iter().zip(&forces).map(|(slope, (_, force))| slope.dot(*force)).sum()
        };
        (0..self.model.joints.len()).map(work).collect()
    }

    fn dynamics(&self) -> (InverseDynamics, Posture) {
        let posture = self.posture(&self.configuration(0.0));
        (InverseDynamics::new(&self.model, &posture, &self.at), posture)
    }
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found_one, one) in found.iter().zip(expected) {
        assert!((found_one - one).abs() < TOLERANCE, "{found:?} {expected:?}");
    }
}

#[test]
fn the_contacts_exert_what_moves_all_points_and_carries_their_weight() {
    for seed in 0..20 {
        let case = Case::new(seed);
        let forces = case.forces();
        let force: DVec3 = forces.iter().map(|(_, force)| *force).sum();
        let torque: DVec3 = forces.iter().map(|(at, force)| at.cross(*force)).sum();
        let (dynamics, _) = case.dynamics();
        assert_near(&dynamics.contacts.force.to_array(), &force.to_array());
        assert_near(&dynamics.contacts.torque.to_array(), &torque.to_array());
    }
}

#[test]
fn torques_do_the_work_of_all_forces() {
    for seed in 0..20 {
        let case = Case::new(seed);
        let (dynamics, posture) = case.dynamics();
        let free = case.free_torques();
        assert_near(&dynamics.torques_under(&case.model, &posture, (&[], &[])), &free);
        // Three forces at points of each foot.
        let random = &mut randoms(seed + 100);
        let weight = case.model.mass() * GRAVITY;
        // On one foot in some cases.
        let limb = |index: usize| if seed % 4 == 0 { 0 } else { index % 2 };
        let at_foot: Vec<(usize, DVec3)> =
            (0..6).map(|index| (limb(index), 0.3 * vector(random))).collect();
        let places = |configuration: &Configuration| -> Vec<DVec3> {
            let posture = case.posture(configuration);
            let place = |&(limb, at): &(usize, DVec3)| posture.world_from_link[1 + limb] * at;
            at_foot.iter().map(place).collect()
        };
        let generators: Vec<Generator> = places(&case.configuration(0.0))
            .into_iter()
            .zip(&at_foot)
            .map(|(point, &(limb, _))| Generator { limb, point, force: vector(random) })
            .collect();
        let shares: Vec<f64> = generators.iter().map(|_| random(0.0, 0.3)).collect();
        let work = |joint: usize| -> f64 {
            let slopes = case.slopes(joint, places);
            let forces = generators.iter().zip(&shares).zip(&slopes);
            forces
                .map(|((generator, share), slope)| weight * share * generator.force.dot(*slope))
                .sum()
        };
        let expected: Vec<f64> =
            free.iter().enumerate().map(|(joint, free)| free - work(joint)).collect();
        let found = dynamics.torques_under(&case.model, &posture, (&generators, &shares));
        assert_near(&found, &expected);
    }
}

#[test]
fn forces_that_exert_the_wrench_of_the_contacts_are_balanced() {
    let random = &mut randoms(7);
    let case = Case::new(3);
    let (mut dynamics, _) = case.dynamics();
    let weight = case.model.mass() * GRAVITY;
    let generators: Vec<Generator> = (0..9)
        .map(|_| Generator { limb: 0, point: vector(random), force: vector(random) })
        .collect();
    let shares: Vec<f64> = generators.iter().map(|_| random(0.0, 1.0)).collect();
    let forces = || generators.iter().zip(&shares).map(|(g, share)| (g.point, *share * g.force));
    dynamics.contacts = Wrench {
        force: weight * forces().map(|(_, force)| force).sum::<DVec3>(),
        torque: weight * forces().map(|(at, force)| at.cross(force)).sum::<DVec3>(),
    };
    for (row, right) in dynamics.balance(&case.model, &generators) {
        assert!((dot(&row, &shares) - right).abs() < 1e-9, "{row:?} {right}");
    }
}

#[test]
fn joints_that_the_waypoint_does_not_have_are_locked() {
    // Forty-eight joints and one more, on a chain that hangs from the torso.
    let mut case = Case::new(1);
    let last = case.model.links.len() - 1;
    while case.model.joints.len() <= case.at.q.len() {
        let (mut link, mut joint) = (case.model.links[last].clone(), case.model.joints[0].clone());
        joint.child = case.model.links.len();
        let attachment = link.parent.as_mut().unwrap();
        (attachment.parent, attachment.joint) = (joint.child - 1, Some(case.model.joints.len()));
        case.model.links.push(link);
        case.model.joints.push(joint);
    }
    let mut configuration = case.configuration(0.0);
    configuration.q.resize(case.model.joints.len(), 0.3);
    let posture = case.posture(&configuration);
    let motions = link_motions(&case.model, &posture, &case.at);
    let [parent, child] = [motions.len() - 2, motions.len() - 1].map(|link| &motions[link]);
    assert_eq!((child.omega, child.alpha), (parent.omega, parent.alpha));
}

#[test]
fn the_zero_moment_point_is_where_a_force_acts_and_nothing_pulls() {
    let (force, at) = (DVec3::new(30.0, -50.0, 400.0), DVec3::new(0.4, -0.3, 0.2));
    let wrench = Wrench { force, torque: at.cross(force) + 7.0 * DVec3::Z };
    assert!(wrench.zero_moment_point(at.z).distance(at) < 1e-12);
    // Further up along the force's line.
    let higher = at + 0.5 * force / force.z;
    assert!(wrench.zero_moment_point(at.z + 0.5).distance(higher) < 1e-12);
    for force in [-force, DVec3::X, DVec3::NAN] {
        let point = Wrench { force, ..wrench }.zero_moment_point(0.0);
        assert!(point.x.is_nan() && point.y.is_nan(), "{point}");
    }
}

/// The robot in a stride, whose arm moves, with weak hips of different strengths.
fn on_both_feet(speed: f64) -> (RobotModel, Posture, InverseDynamics, Vec<Generator>) {
    let mut model = robot();
    (model.joints[0].effort, model.joints[1].effort) = (31.0, 57.0);
    let mut at = waypoint(0.0, 0.7, 0.4);
    at.q[..2].copy_from_slice(&[0.4, -0.2]);
    at.joint_velocity[2..4].copy_from_slice(&[speed, -speed]);
    at.joint_acceleration[2..4].copy_from_slice(&[2.0 * speed, speed]);
    let posture = Posture::new(&model, &Configuration::of_waypoint(&at, 4));
    let dynamics = InverseDynamics::new(&model, &posture, &at);
    let generators = Equilibrium::new(0.6).generators(&level_soles(&model, &posture), ALL_FRICTION);
    (model, posture, dynamics, generators)
}

fn largest_share(model: &RobotModel, torques: &[f64]) -> f64 {
    let shares =
        model.joints.iter().zip(torques).map(|(joint, torque)| torque.abs() / joint.effort);
    shares.fold(0.0, f64::max)
}

#[test]
fn no_other_forces_load_the_joints_less() {
    for speed in [0.0, 0.5] {
        let (model, posture, dynamics, generators) = on_both_feet(speed);
        let rows = dynamics.balance(&model, &generators);
        let mut simplex = Simplex::at_vertex(&rows, &[]).unwrap();
        let mut random = randoms(5);
        let arms = largest_share(&model, &[&[0.0; 2], &dynamics.free[2..]].concat());
        for share_max in [0.95, 1e-6] {
            let torques = dynamics.torques(&model, &posture, &generators, share_max).unwrap();
            let best = largest_share(&model, &torques);
            // The arm's torques do not depend on the contacts.
            assert_eq!(torques[2..], dynamics.free[2..]);
            assert!(best >= arms - 1e-9);
            let mut least = f64::INFINITY;
            for _ in 0..200 {
                let cost: Vec<f64> = generators.iter().map(|_| random(-1.0, 1.0)).collect();
                let forces = simplex.minimise(&cost).unwrap();
                let other = dynamics.torques_under(&model, &posture, (&generators, &forces));
                least = least.min(largest_share(&model, &other));
                // Both hips together carry the same, whichever foot does.
                let sum = |torques: &[f64]| torques[0] + torques[1];
                assert!((sum(&other) - sum(&torques)).abs() < 1e-3, "{torques:?} {other:?}");
            }
            assert!(least > best - 1e-6, "{least} {best}");
        }
    }
}

#[test]
fn a_wrench_beyond_friction_has_no_torques() {
    let (model, posture, mut dynamics, generators) = on_both_feet(0.0);
    dynamics.contacts.force.x += model.mass() * GRAVITY;
    assert_eq!(dynamics.torques(&model, &posture, &generators, 0.95), None);
}
