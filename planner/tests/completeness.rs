//! What the search reaches only by its last resorts: docs/COMPLETENESS.md.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, preparation_for, with_split_hip};
use glam::{DQuat, DVec2, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{Foothold, double_mode, single_mode};
use surefoot_planner::constraints::mode_state::ModeState;
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::motion::cbirrt::SingleModeProblem;
use surefoot_planner::motion::single_mode::solve;
use surefoot_planner::motion::workspace::Workspace;
use surefoot_planner::primitives::transition_configuration::{is_unbounded, sample};
use surefoot_planner::primitives::transition_pair::TransitionPair;
use surefoot_planner::robot::crouch::Crouch;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::robot::posture_ik::{Posture, solve_posture};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

/// Seeds of each test.
const SEEDS: u64 = 20;
/// Waypoints of a motion, and nodes of a tree.
const WORKSPACE: [usize; 2] = [1024, 1024];

/// A floor with a box over it: its centre and half of each side, m.
fn constraints_under(center: [f64; 3], half_extents: [f64; 3]) -> Constraints {
    let case = Case::shipped("flat_walk").with_box(center, half_extents);
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    Constraints::new(robot, collision, config)
}

/// A foothold on the floor.
fn foothold(constraints: &Constraints, limb: usize, at: DVec2) -> Foothold {
    let pose = Pose::from_parts(at.extend(0.0), DQuat::IDENTITY);
    Foothold::whole(&constraints.robot, limb, pose)
}

#[test]
fn samples_reach_postures_outside_the_boxes() {
    let constraints = constraints_under([5.0, 0.0, 1.5], [2.0, 1.0, 0.5]);
    let [stance, other] =
        [(0, 0.12), (1, -0.12)].map(|(limb, y)| foothold(&constraints, limb, DVec2::new(5.0, y)));
    let (mode, pair) = (single_mode(&stance), TransitionPair { stance: &stance, other: &other });
    let holds =
        |seed: u64, attempt: u64| sample(&constraints, &mode, pair, (seed, 0), attempt).is_ok();
    for seed in 1..=SEEDS {
        let (unbounded, boxed): (Vec<u64>, Vec<u64>) =
            (0..6_000).partition(|&attempt| is_unbounded(attempt));
        let count =
            |attempts: &[u64]| attempts.iter().filter(|&&attempt| holds(seed, attempt)).count();
        assert_eq!(count(&boxed), 0, "seed {seed}");
        assert!(count(&unbounded) > 0, "seed {seed}");
    }
}

/// A step of 0.3 m whose weight shift leads the head from behind a bar to before it.
fn shift_below_a_bar(constraints: &Constraints) -> SingleModeProblem {
    let behind = foothold(constraints, 0, DVec2::new(4.85, 0.1));
    let ahead = foothold(constraints, 1, DVec2::new(5.15, -0.1));
    let state = |stance: &Foothold, other: &Foothold| {
        let pair = TransitionPair { stance, other };
        let mode = single_mode(stance);
        let found =
            (0..600).find_map(|attempt| sample(constraints, &mode, pair, (1, 0), attempt).ok());
        ModeState { configuration: found.unwrap(), world_from_soles: pair.world_from_soles() }
    };
    SingleModeProblem {
        mode: double_mode(&behind, &ahead),
        from: state(&behind, &ahead),
        to: state(&ahead, &behind),
        random: (1, 1),
        failures: 0,
    }
}

#[test]
fn a_motion_outside_the_first_box_is_found_after_failures() {
    let constraints = constraints_under([5.0, 0.0, 1.23], [0.01, 0.6, 0.01]);
    let problem = shift_below_a_bar(&constraints);
    let head = |state: &ModeState| state.configuration.world_from_root.translation.x;
    assert!(head(&problem.from) < 4.9 && head(&problem.to) > 5.1);
    let mut workspace = Workspace::new(WORKSPACE[0], WORKSPACE[1]);
    for seed in 1..=SEEDS {
        let mut finds = |failures: u32| {
            let problem = SingleModeProblem { random: (seed, 1), failures, ..problem.clone() };
            solve(&constraints, &problem, &mut workspace).is_ok()
        };
        assert!(!(0..=4).any(&mut finds), "seed {seed}: within the first box");
        assert!((5..25).any(&mut finds), "seed {seed}");
    }
}

/// Between a ceiling and a box ahead of the shins, both feet side by side.
fn constraints_before_a_box(model: &RobotModel) -> Constraints {
    let case = Case { model: model.clone(), ..Case::shipped("flat_walk") }
        .with_box([5.0, 0.0, 1.55], [2.0, 1.0, 0.25])
        .with_box([5.7, 0.0, 0.675], [0.5, 1.0, 0.575]);
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    Constraints::new(robot, collision, config)
}

#[test]
fn samples_reach_the_other_branch_of_a_knee_that_bends_both_ways() {
    let mut model = common::hubo();
    for joint in model.joints.iter_mut().filter(|joint| joint.name.ends_with("_knee")) {
        joint.lower = -joint.upper;
    }
    let constraints = constraints_before_a_box(&model);
    let knees: Vec<usize> = (0..model.joints.len())
        .filter(|&index| model.joints[index].name.ends_with("_knee"))
        .collect();
    let [stance, other] =
        [(0, 0.12), (1, -0.12)].map(|(limb, y)| foothold(&constraints, limb, DVec2::new(5.0, y)));
    let (mode, pair) = (single_mode(&stance), TransitionPair { stance: &stance, other: &other });
    for seed in 1..=SEEDS {
        let bends_back = |attempt: u64| {
            sample(&constraints, &mode, pair, (seed, 0), attempt)
                .is_ok_and(|found| knees.iter().all(|&knee| found.q[knee] < -0.2))
        };
        assert!((0..80_000).step_by(4).any(bends_back), "seed {seed}");
        let mut from_standing = (0..8_000).filter(|attempt| attempt % 4 != 0);
        assert!(!from_standing.any(bends_back), "seed {seed}");
    }
}

/// Pairs of soles, level or one above the other, that some of `attempts` samples stand on, of
/// `pairs` with a distance within these bounds (m).
fn pairs_with_a_posture(constraints: &Constraints, distances: [f64; 2], pairs: u64) -> usize {
    let stands = |pair: &u64| {
        let mut random = Random::new(*pair, Stream::Preparation, 0, 2);
        let distance = random.uniform(distances[0], distances[1]);
        let rise = random.uniform(-0.5, 0.5);
        let along = (distance * distance - rise * rise).sqrt();
        let bearing = random.uniform(-std::f64::consts::PI, std::f64::consts::PI);
        let turn = random.uniform(-0.8, 0.8);
        let at = DVec3::new(along * libm::cos(bearing), along * libm::sin(bearing), rise);
        let pose = Pose::from_parts(at, DQuat::from_rotation_z(turn));
        let stance = foothold(constraints, 0, DVec2::ZERO);
        let other = Foothold::whole(&constraints.robot, 1, pose);
        let (mode, pair) =
            (single_mode(&stance), TransitionPair { stance: &stance, other: &other });
        (0..1_500).any(|attempt| sample(constraints, &mode, pair, (1, 0), attempt).is_ok())
    };
    (0..pairs).filter(stands).count()
}

#[test]
fn no_posture_is_sampled_on_soles_farther_apart_than_the_farthest() {
    let mut case = Case::shipped("flat_walk");
    case.world.shapes.retain(|shape| shape.name != "floor");
    let case = case.with_box([0.0, 0.0, -9.0], [1.0, 1.0, 0.25]).configured(|planner| {
        (planner.com_margin, planner.effort_share) = (0.0091, 0.93);
    });
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    let constraints = Constraints::new(robot, collision, config);
    let preparation = preparation_for(&case.model, &PlannerConfig::default());
    let [reach, farthest] =
        [preparation.step_limits().reach(), preparation.step_limits().farthest()];
    let count = |distances| pairs_with_a_posture(&constraints, distances, 200);
    let [near, beyond_reach] = [count([0.6, 0.7]), count([reach, farthest])];
    assert!(near > 50 && (1..10).contains(&beyond_reach), "{near}, {beyond_reach}");
    assert_eq!(count([farthest, 1.2 * farthest]), 0);
}

/// The Hubo with hips that turn about yaw, pitch and roll in this order, as some humanoids have:
/// where the root leans so far that the legs stand across it, yaw and roll are about the same axis.
fn with_pitch_before_roll(model: &RobotModel) -> RobotModel {
    let mut model = with_split_hip(model);
    for side in ["left", "right"] {
        let [roll, pitch] = ["roll", "pitch"].map(|axis| {
            let name = format!("{side}_hip_{axis}");
            model.joints.iter().position(|joint| joint.name == name).unwrap()
        });
        let [(a, b), (c, d)] = [roll, pitch].map(|index| {
            let joint = &model.joints[index];
            ((joint.axis, joint.lower, joint.upper), (joint.effort, model.standing_q[index]))
        });
        for (index, (axis, lower, upper), (effort, standing)) in [(roll, c, d), (pitch, a, b)] {
            let joint = &mut model.joints[index];
            (joint.axis, joint.lower, joint.upper, joint.effort) = (axis, lower, upper, effort);
            model.standing_q[index] = standing;
        }
    }
    model
}

#[test]
fn a_leaning_root_is_projected_where_hips_align() {
    let model = with_pitch_before_roll(&common::hubo());
    let case = Case { model, ..Case::shipped("flat_walk") };
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    let constraints = Constraints::new(robot, collision, config);
    let robot = &constraints.robot;
    let [upright, leaning] = [0.0, 1.2].map(|pitch| {
        let crouch = Crouch { leg_extension: 1.0, pitch, ..Crouch::UPRIGHT };
        let [stance, other] = [(0, 0.06), (1, -0.06)].map(|(limb, y)| Foothold {
            crouch,
            ..foothold(&constraints, limb, DVec2::new(5.0, y))
        });
        let (mode, pair) =
            (single_mode(&stance), TransitionPair { stance: &stance, other: &other });
        let is_sampled = |attempt: &u64| {
            let sampled = sample(&constraints, &mode, pair, (1, 0), *attempt);
            !matches!(sampled, Err(Rejection::Unreachable | Rejection::Balance))
        };
        let is_solved_leg_by_leg = |index: &u64| {
            let posture = Posture {
                world_from_root: DQuat::from_rotation_y(pitch),
                leg_extension: robot.standing_leg_extension,
                com: mode.region.centroid() - 0.002 * *index as f64 * DVec2::Y,
            };
            solve_posture(robot, &pair.world_from_soles(), &posture, robot.standing_q).is_ok()
        };
        [(0..12).filter(is_sampled).count(), (0..12).filter(is_solved_leg_by_leg).count()]
    });
    assert!(upright[0] >= 10 && upright[1] == 12, "{upright:?}");
    assert!(leaning[0] >= 8 && leaning[1] == 0, "{leaning:?}");
}
