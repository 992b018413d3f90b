//! A robot whose waist bends forward does so under obstacles: decision 0037.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, repository, run};
use glam::DVec3;
use surefoot_planner::Outcome;
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;

/// Most that the waist turns forward, rad.
const BEND_LIMIT: f64 = 0.68;

/// The Hubo whose waist pitches instead of yawing.
fn with_pitching_waist() -> RobotModel {
    let mut model = common::hubo();
    let waist = waist(&model);
    let joint = &mut model.joints[waist];
    (joint.axis, joint.lower, joint.upper) = (DVec3::Y, -0.3, BEND_LIMIT);
    model
}

fn waist(model: &RobotModel) -> usize {
    model.joints.iter().position(|joint| joint.name == "waist_yaw").unwrap()
}

/// A walk on level ground under a beam whose underside is `height` (m) above it.
fn under_a_beam(model: RobotModel, height: f64, seed: u64) -> Case {
    let mut case = Case { model, ..Case::shipped("flat_walk") }.with_seed(seed);
    let path = repository().join("configs/worlds/holes/low_beam.toml");
    case.world = load_world(&path).unwrap();
    let beam = case.world.shapes.iter_mut().find(|shape| shape.name == "beam").unwrap();
    beam.world_from_shape.translation.z += height - 1.05;
    case.scenario.start.position = 0.7 * DVec3::X;
    case.scenario.goal.position = 4.3 * DVec3::X;
    case.configured(|planner| planner.work_max = 200_000)
}

#[test]
fn a_robot_whose_waist_bends_passes_under_a_lower_beam() {
    let model = with_pitching_waist();
    let waist = waist(&model);
    let is_bent = |chunk: &PlanChunk| chunk.waypoints().iter().any(|it| it.q[waist] > 0.3);
    for seed in 1..=4 {
        let mut planner = under_a_beam(model.clone(), 1.0, seed).planner(2);
        assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "seed {seed}");
        assert!(planner.chunks().iter().any(is_bent), "seed {seed}");
    }
    let mut planner = under_a_beam(common::hubo(), 1.0, 1).planner(2);
    assert_ne!(run(&mut planner, u64::MAX), Outcome::Found);
}

#[test]
fn the_waist_bends_no_farther_than_links_are_free() {
    let case = under_a_beam(with_pitching_waist(), 1.05, 1);
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    let constraints = Constraints::new(robot, collision, config);
    let robot = &constraints.robot;
    let is_free = |bend: f64| {
        let mut q = robot.standing_q;
        q[waist(&case.model)] += bend;
        let bent = Configuration { world_from_root: Pose::IDENTITY, q };
        constraints.collision.self_hit(&KinematicState::new(robot, &bent)).is_none()
    };
    let most = constraints.waist_bend_max();
    assert!(most > 0.3 && most < BEND_LIMIT, "{most}");
    assert!((0..=100).all(|part| is_free(0.01 * f64::from(part) * most)));
    assert!(!is_free(most + 0.02));
}
