//! Inverse dynamics: against Pinocchio, and against the energy of random motions.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;
#[path = "common/pinocchio.rs"]
mod pinocchio;
#[path = "common/power.rs"]
mod power;

use common::hubo;
use glam::{DQuat, DVec3};
use pinocchio::{numbers, reference};
use power::power;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::robot::inverse_dynamics::{InverseDynamics, LinkFrames, VELOCITY_MAX};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;
use surefoot_shared_types::robot::model::RobotModel;

#[test]
fn torques_of_gravity_agree_with_pinocchio() {
    let (data, model) = (reference(), hubo());
    let dynamics = InverseDynamics::new(&model);
    let names: Vec<&str> =
        data["joint_names"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    for case in data["configurations"].as_array().unwrap() {
        let (from, expected) = (numbers(&case["q"]), numbers(&case["gravity_torques"]));
        let at = |name: &str| names.iter().position(|other| *other == name).unwrap();
        let mut q = [0.0; JOINTS_MAX];
        model.joints.iter().enumerate().for_each(|(i, joint)| q[i] = from[at(&joint.name)]);
        let rotation = DQuat::from_slice(&numbers(&case["root_quat_xyzw"])).normalize();
        let root = Pose::from_parts(DVec3::from_slice(&numbers(&case["root_xyz"])), rotation);
        let mut frames = LinkFrames::default();
        dynamics.place(&root, &q, &mut frames);
        let rest = [0.0; VELOCITY_MAX];
        let effort = dynamics.effort(&frames, &rest, &rest, 9.81);
        for (i, joint) in model.joints.iter().enumerate() {
            assert!((effort.torques[i] - expected[at(&joint.name)]).abs() < 1e-6, "{}", joint.name);
        }
        assert!((effort.force.z - 9.81 * model.mass()).abs() < 1e-6);
    }
}

/// A random motion: the configuration at time `t`, its velocities, and its accelerations at 0.
struct RandomMotion {
    root: Pose,
    q: [f64; JOINTS_MAX],
    v: [f64; VELOCITY_MAX],
    a: [f64; VELOCITY_MAX],
}

impl RandomMotion {
    fn new(model: &RobotModel, seed: u64) -> Self {
        let mut random = Random::new(seed, Stream::Shortcut, 0, 0);
        let mut number = |size: f64| random.uniform(-size, size);
        let count = 6 + model.joints.len();
        let rotation = rotation_from_scaled_axis(DVec3::new(number(1.0), number(1.0), number(1.0)));
        let mut motion = Self {
            root: Pose::from_parts(DVec3::new(number(1.0), number(1.0), number(1.0)), rotation),
            q: [0.0; JOINTS_MAX],
            v: [0.0; VELOCITY_MAX],
            a: [0.0; VELOCITY_MAX],
        };
        motion.q[..count - 6].iter_mut().for_each(|q| *q = number(1.0));
        motion.v[..count].iter_mut().for_each(|v| *v = number(2.0));
        motion.a[..count].iter_mut().for_each(|a| *a = number(3.0));
        motion
    }

    fn at(&self, t: f64) -> (Pose, [f64; JOINTS_MAX], [f64; VELOCITY_MAX]) {
        let v = std::array::from_fn(|i| self.v[i] + t * self.a[i]);
        let q = std::array::from_fn(|j| self.q[j] + t * (self.v[6 + j] + 0.5 * t * self.a[6 + j]));
        let of = |list: &[f64], at: usize| DVec3::from_slice(&list[at..]);
        let step = |at: usize| t * (of(&self.v, at) + 0.5 * t * of(&self.a, at));
        let rotation = (rotation_from_scaled_axis(step(3)) * self.root.rotation).normalize();
        (Pose::from_parts(self.root.translation + step(0), rotation), q, v)
    }
}

/// Kinetic energy: half of the velocities times the efforts that would accelerate by them.
fn kinetic_energy(
    robot: &InverseDynamics,
    (root, q, v): &(Pose, [f64; JOINTS_MAX], [f64; VELOCITY_MAX]),
) -> f64 {
    let mut frames = LinkFrames::default();
    robot.place(root, q, &mut frames);
    let effort = robot.effort(&frames, &[0.0; VELOCITY_MAX], v, 0.0);
    0.5 * power(&effort, v)
}

#[test]
fn the_power_of_a_motion_is_the_change_of_its_energy() {
    let model = hubo();
    let robot = InverseDynamics::new(&model);
    for seed in 0..20 {
        let motion = RandomMotion::new(&model, seed);
        let h = 1e-5;
        let [before, after] = [-h, h].map(|t| kinetic_energy(&robot, &motion.at(t)));
        let mut frames = LinkFrames::default();
        robot.place(&motion.root, &motion.q, &mut frames);
        let effort = robot.effort(&frames, &motion.v, &motion.a, 0.0);
        let (expected, actual) = ((after - before) / (2.0 * h), power(&effort, &motion.v));
        assert!((expected - actual).abs() < 1e-5 * (1.0 + expected.abs()), "{expected} {actual}");
    }
}
