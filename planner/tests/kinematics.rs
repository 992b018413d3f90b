//! Forward kinematics compared with Pinocchio, inverse kinematics of legs with forward kinematics.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;
#[path = "common/pinocchio.rs"]
mod pinocchio;

use common::{Hinge, chain_robot, hinge, hubo, random_positions, with_split_hip};
use glam::{DQuat, DVec3};
use pinocchio::{numbers, reference};
use serde_json::Value;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::kinematics::leg::LegError;
use surefoot_planner::kinematics::{Kinematics, Leg};
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_distance, rotation_from_scaled_axis};
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::{JointKind, RobotModel};

const SAMPLES: u64 = 100_000;
const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const ORIGIN: [f64; 3] = [0.0; 3];

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

fn rotation(value: &Value) -> DQuat {
    DQuat::from_slice(&numbers(value)).normalize()
}

fn index_of(names: &Value, name: &str) -> usize {
    names.as_array().unwrap().iter().position(|other| other == name).unwrap()
}

/// The left leg of Talos from its data sheet.
fn talos_hinges() -> [Hinge; 6] {
    [
        hinge([-0.02, 0.085, -0.271], Z, [-0.349, 1.571]),
        hinge(ORIGIN, X, [-0.524, 0.524]),
        hinge(ORIGIN, Y, [-2.095, 0.7]),
        hinge([0.0, 0.0, -0.38], Y, [0.0, 2.618]),
        hinge([0.0, 0.0, -0.325], Y, [-1.309, 0.768]),
        hinge(ORIGIN, X, [-0.524, 0.524]),
    ]
}

fn talos_leg() -> RobotModel {
    chain_robot(&talos_hinges(), [0.0, 0.0, -0.107])
}

/// A leg with its knee ahead and to the side of the thigh, two reversed axes, and joints without
/// limits.
fn crooked_leg() -> RobotModel {
    let unlimited = [-3.1, 3.1];
    let (backward_y, backward_x) = ([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]);
    let hinges = [
        hinge([0.0, 0.1, -0.1], Z, unlimited),
        hinge(ORIGIN, backward_x, unlimited),
        hinge(ORIGIN, Y, unlimited),
        hinge([0.04, 0.015, -0.36], backward_y, unlimited),
        hinge([-0.02, 0.01, -0.33], Y, unlimited),
        hinge(ORIGIN, X, unlimited),
    ];
    chain_robot(&hinges, [0.03, 0.0, -0.09])
}

fn hubo_with_split_hip() -> RobotModel {
    with_split_hip(&hubo())
}

fn distance(leg: &Leg, a: &[f64], b: &[f64]) -> f64 {
    leg.joints().iter().map(|joint| (a[joint.index] - b[joint.index]).powi(2)).sum::<f64>().sqrt()
}

fn pose_error(a: &Pose, b: &Pose) -> f64 {
    a.translation.distance(b.translation).max(rotation_distance(a.rotation, b.rotation))
}

fn within_limits(leg: &Leg, q: &[f64]) -> bool {
    leg.joints().iter().all(|joint| (joint.lower..=joint.upper).contains(&q[joint.index]))
}

#[test]
fn link_poses_and_the_centre_of_mass_agree_with_pinocchio() {
    let data = reference();
    let model = hubo();
    let kinematics = Kinematics::new(&model);
    assert!((kinematics.mass() - data["mass"].as_f64().unwrap()).abs() < 1e-9);
    let cases = data["configurations"].as_array().unwrap();
    assert!(cases.len() >= 20 && model.links.len() == data["link_names"].as_array().unwrap().len());
    let mut poses = vec![Pose::IDENTITY; kinematics.links_len()];
    for case in cases {
        let pinocchio_q = numbers(&case["q"]);
        let q: Vec<f64> = model
            .joints
            .iter()
            .map(|joint| pinocchio_q[index_of(&data["joint_names"], &joint.name)])
            .collect();
        let world_from_root =
            Pose::from_parts(vector(&case["root_xyz"]), rotation(&case["root_quat_xyzw"]));
        kinematics.forward(&world_from_root, &q, &mut poses);
        for (link, pose) in model.links.iter().zip(&poses) {
            let at = index_of(&data["link_names"], &link.name);
            let expected = Pose::from_parts(
                vector(&case["links_xyz"][at]),
                rotation(&case["links_quat_xyzw"][at]),
            );
            assert!(
                pose_error(pose, &expected) < 1e-9,
                "{}: {pose:?}, not {expected:?}",
                link.name
            );
        }
        assert!(kinematics.center_of_mass(&poses).distance(vector(&case["com"])) < 1e-9);
    }
}

/// For a robot with a fixed link that has mass, and for one with prismatic knees. Every second
/// configuration moves the legs only, so that the upper body is kept from the one before.
#[test]
fn an_updated_kinematic_state_agrees_with_forward_kinematics() {
    let mut sliding = hubo();
    for joint in sliding
        .joints
        .iter_mut()
        .filter(|joint| joint.name.ends_with("knee") || joint.name.ends_with("elbow"))
    {
        (joint.kind, joint.axis) = (JointKind::Prismatic, DVec3::new(0.6, 0.0, 0.8));
    }
    for model in [hubo(), sliding] {
        let (kinematics, robot) =
            (Kinematics::new(&model), Mechanism::new(&model, &PlannerConfig::default()).unwrap());
        assert!(
            robot.tree.nodes().len() < model.links.len()
                && (1..robot.tree.nodes().len()).contains(&robot.tree.upper_body_len())
        );
        let mut poses = vec![Pose::IDENTITY; model.links.len()];
        let mut kinematic_state = KinematicState::default();
        let mut random = Random::new(1, Stream::Preparation, 0, 0);
        let mut q = robot.standing_q;
        for index in 0..1_000 {
            let sampled = random_positions(&model, 0.0, &mut random);
            let moves = |joint: &usize| {
                index % 2 == 0
                    || robot
                        .legs
                        .iter()
                        .any(|leg| leg.joints().iter().any(|of_leg| of_leg.index == *joint))
            };
            (0..sampled.len()).filter(moves).for_each(|joint| q[joint] = sampled[joint]);
            let mut vector =
                || DVec3::from_array(std::array::from_fn(|_| random.uniform(-1.5, 1.5)));
            let world_from_root = Pose::from_parts(vector(), rotation_from_scaled_axis(vector()));
            kinematics.forward(&world_from_root, &q, &mut poses);
            kinematic_state.update(&robot, &Configuration { world_from_root, q });
            assert!(kinematic_state.com.distance(kinematics.center_of_mass(&poses)) < 1e-12);
            for (link, pose) in poses.iter().enumerate() {
                assert!(
                    pose_error(&kinematic_state.world_from_link(&robot, link), pose) < 1e-12,
                    "{}",
                    model.links[link].name
                );
            }
        }
    }
}

#[test]
fn the_sole_pose_of_a_leg_agrees_with_forward_kinematics() {
    let mut sliding = talos_hinges();
    sliding[3].kind = JointKind::Prismatic;
    sliding[3].limits = [-0.1, 0.2];
    for model in [
        hubo(),
        talos_leg(),
        crooked_leg(),
        hubo_with_split_hip(),
        chain_robot(&sliding, [0.0, 0.0, -0.1]),
    ] {
        let kinematics = Kinematics::new(&model);
        let mut poses = vec![Pose::IDENTITY; kinematics.links_len()];
        let mut random = Random::new(1, Stream::Preparation, 0, 0);
        for (limb, foot) in model.feet.iter().enumerate() {
            let leg = Leg::new(&model, limb, 0.0).unwrap();
            for _ in 0..1_000 {
                let q = random_positions(&model, 0.0, &mut random);
                kinematics.forward(&Pose::IDENTITY, &q, &mut poses);
                assert!(
                    pose_error(&leg.root_from_sole(&q), &(poses[foot.link] * foot.link_from_sole))
                        < 1e-12
                );
            }
        }
    }
}

/// Solves for the soles of random joint positions from random hints. Checks that the solution is
/// correct, within the limits and nearest: not farther from the hint than the sampled positions.
fn closed_form_round_trip(model: &RobotModel, limb: usize) {
    const MARGIN: f64 = 0.005;
    let leg = Leg::new(model, limb, MARGIN).unwrap();
    assert!(leg.is_closed_form());
    let mut random = Random::new(2, Stream::Preparation, limb as u64, 0);
    for sample in 0..SAMPLES {
        let mut sampled_q = random_positions(model, MARGIN, &mut random);
        // The knee never bends backward.
        for joint in leg.joints() {
            if !joint.is_within_limits(sampled_q[joint.index]) {
                sampled_q[joint.index] = random.uniform(joint.lower, joint.upper);
            }
        }
        let hint = random_positions(model, MARGIN, &mut random);
        let sole = leg.root_from_sole(&sampled_q);
        let mut q = hint.clone();
        assert!(leg.solve(&sole, &mut q), "sample {sample}: {sampled_q:?}");
        assert!(
            pose_error(&leg.root_from_sole(&q), &sole) < 1e-8,
            "sample {sample}: {sampled_q:?} became {q:?}"
        );
        assert!(within_limits(&leg, &q), "sample {sample}: {q:?}");
        let (found, sampled) = (distance(&leg, &q, &hint), distance(&leg, &sampled_q, &hint));
        assert!(
            found <= sampled + 1e-6,
            "sample {sample}: {q:?} is farther from {hint:?} than {sampled_q:?}"
        );
    }
}

#[test]
fn hubo_legs_solve_every_reachable_sole() {
    let model = hubo();
    closed_form_round_trip(&model, 0);
    closed_form_round_trip(&model, 1);
}

#[test]
fn a_talos_leg_solves_every_reachable_sole() {
    closed_form_round_trip(&talos_leg(), 0);
}

#[test]
fn a_crooked_leg_solves_every_reachable_sole() {
    closed_form_round_trip(&crooked_leg(), 0);
}

#[test]
fn each_of_eight_branches_is_found_from_nearby() {
    let model = crooked_leg();
    let leg = Leg::new(&model, 0, 0.0).unwrap();
    let mut random = Random::new(3, Stream::Preparation, 0, 0);
    let mut most = 0;
    for _ in 0..100 {
        let sole = leg.root_from_sole(&random_positions(&model, 0.0, &mut random));
        let mut branches: Vec<Vec<f64>> = vec![];
        for _ in 0..400 {
            let mut q = random_positions(&model, 0.0, &mut random);
            assert!(leg.solve(&sole, &mut q));
            if branches.iter().all(|branch| distance(&leg, branch, &q) > 1e-4) {
                branches.push(q);
            }
        }
        for branch in &branches {
            let mut q: Vec<f64> =
                branch.iter().map(|position| position + random.uniform(-1e-3, 1e-3)).collect();
            assert!(leg.solve(&sole, &mut q) && distance(&leg, &q, branch) < 1e-6);
        }
        most = most.max(branches.len());
    }
    assert_eq!(most, 8);
}

/// The share of soles that the iteration solves from hints near their sampled positions. Every
/// solution must be correct and within the limits.
fn newton_round_trip(model: &RobotModel, deviation: f64, samples: u64) -> f64 {
    const MARGIN: f64 = 0.005;
    let leg = Leg::new(model, 0, MARGIN).unwrap();
    assert!(!leg.is_closed_form());
    let mut random = Random::new(4, Stream::Preparation, 0, 0);
    let mut reached = 0;
    for sample in 0..samples {
        let sampled_q = random_positions(model, MARGIN, &mut random);
        let sole = leg.root_from_sole(&sampled_q);
        let hint: Vec<f64> = sampled_q
            .iter()
            .map(|position| position + random.uniform(-deviation, deviation))
            .collect();
        let mut q = hint.clone();
        if leg.solve(&sole, &mut q) {
            reached += 1;
            assert!(
                pose_error(&leg.root_from_sole(&q), &sole) < 1e-8,
                "sample {sample}: {sampled_q:?} became {q:?}"
            );
            assert!(within_limits(&leg, &q), "sample {sample}: {q:?}");
        } else {
            assert_eq!(q, hint, "sample {sample}");
        }
    }
    reached as f64 / samples as f64
}

#[test]
fn a_leg_whose_hip_axes_do_not_intersect_is_solved() {
    let model = hubo_with_split_hip();
    let near = newton_round_trip(&model, 0.04, SAMPLES);
    let farther = newton_round_trip(&model, 0.3, SAMPLES / 10);
    assert!(near > 0.99, "{near}");
    assert!(farther > 0.9, "{farther}");
}

#[test]
fn a_leg_of_seven_joints_is_solved() {
    let mut hinges: Vec<Hinge> = talos_hinges().into();
    hinges.insert(4, hinge([0.0, 0.0, -0.05], Z, [-0.5, 0.5]));
    let reached = newton_round_trip(&chain_robot(&hinges, [0.0, 0.0, -0.1]), 0.04, SAMPLES / 10);
    assert!(reached > 0.95, "{reached}");
}

#[test]
fn soles_out_of_reach_have_no_solution_and_leave_q_unchanged() {
    for model in [hubo(), talos_leg(), hubo_with_split_hip()] {
        let leg = Leg::new(&model, 0, 0.0).unwrap();
        let mut random = Random::new(5, Stream::Preparation, 0, 0);
        for _ in 0..1_000 {
            let q = random_positions(&model, 0.0, &mut random);
            let mut sole = leg.root_from_sole(&q);
            let away = (sole.translation - leg.hip()).normalize();
            sole.translation =
                leg.hip() + away * (leg.reach() + leg.sole_from_ankle().length() + 0.02);
            let mut moved = q.clone();
            assert!(!leg.solve(&sole, &mut moved));
            assert_eq!(moved, q);
        }
    }
}

#[test]
fn soles_beyond_the_limits_have_no_solution_or_another_branch() {
    let model = hubo();
    let leg = Leg::new(&model, 0, 0.0).unwrap();
    let mut random = Random::new(6, Stream::Preparation, 0, 0);
    let mut unsolved = 0;
    for _ in 0..10_000 {
        let q: Vec<f64> = model.joints.iter().map(|_| random.uniform(-3.1, 3.1)).collect();
        let hint = random_positions(&model, 0.0, &mut random);
        let sole = leg.root_from_sole(&q);
        let mut moved = hint.clone();
        if leg.solve(&sole, &mut moved) {
            assert!(
                within_limits(&leg, &moved)
                    && pose_error(&leg.root_from_sole(&moved), &sole) < 1e-8
            );
        } else {
            assert_eq!(moved, hint);
            unsolved += 1;
        }
    }
    assert!((5_000..10_000).contains(&unsolved), "{unsolved}");
}

#[test]
fn joints_of_other_limbs_do_not_move() {
    let model = hubo();
    let leg = Leg::new(&model, 0, 0.0).unwrap();
    let mut random = Random::new(7, Stream::Preparation, 0, 0);
    let before = random_positions(&model, 0.0, &mut random);
    let mut q = before.clone();
    assert!(leg.solve(&leg.root_from_sole(&model.standing_q), &mut q));
    let is_of_leg = |index: usize| leg.joints().iter().any(|joint| joint.index == index);
    assert!((0..q.len()).filter(|&index| !is_of_leg(index)).all(|index| q[index] == before[index]));
    assert_ne!(q, before);
}

#[test]
fn a_leg_needs_six_to_eight_joints() {
    let hinges = talos_hinges();
    let five = Leg::new(&chain_robot(&hinges[..5], ORIGIN), 0, 0.0).unwrap_err();
    assert_eq!(five, LegError::JointCount { foot: "left".into(), joints: 5 });
    let nine: Vec<Hinge> = talos_hinges().into_iter().chain(talos_hinges()).take(9).collect();
    assert_eq!(
        Leg::new(&chain_robot(&nine, ORIGIN), 0, 0.0).unwrap_err(),
        LegError::JointCount { foot: "left".into(), joints: 9 }
    );
}
