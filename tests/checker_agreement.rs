//! Planner and checker compute kinematics and statics with separate code; the results must agree.
//!
//! `SUREFOOT_ROBOTS=a/robot.toml:b/robot.toml` adds robots that are not shipped.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic fails the test; the comparisons are printed"
)]

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec2, DVec3};
use surefoot_controller_sim::kinematics::forward::{Configuration, Posture};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::robot::configuration as planner;
use surefoot_planner::robot::gravity_torques::{FootLoad, write_torques};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

/// Random configurations of each robot.
const CONFIGURATIONS: u64 = 100_000;
/// The largest difference of positions (m) and rotations (rad).
const POSE_MAX: f64 = 1e-9;
/// The largest difference of torques, N m for each kilogram of the robot.
const TORQUE_MAX: f64 = 1e-9;

fn robots() -> Vec<PathBuf> {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots");
    let folders =
        std::fs::read_dir(shipped).unwrap().map(|entry| entry.unwrap().path().join("robot.toml"));
    let named = std::env::var_os("SUREFOOT_ROBOTS").unwrap_or_default();
    let mut robots: Vec<PathBuf> =
        folders.filter(|path| path.is_file()).chain(std::env::split_paths(&named)).collect();
    robots.retain(|path| !path.as_os_str().is_empty());
    robots.sort();
    robots
}

fn random_configuration(model: &RobotModel, random: &mut Random) -> Configuration {
    let mut between = |low: f64, high: f64| random.uniform(low, high);
    let position = DVec3::from_array([between(-9.0, 9.0), between(-9.0, 9.0), between(-2.0, 2.0)]);
    let rotation = DQuat::from_array([
        between(-1.0, 1.0),
        between(-1.0, 1.0),
        between(-1.0, 1.0),
        between(0.1, 1.0),
    ])
    .normalize();
    let q = model
        .joints
        .iter()
        .map(|joint| between(joint.lower.max(-PI), joint.upper.min(PI)))
        .collect();
    Configuration { world_from_root: Pose::from_parts(position, rotation), q }
}

/// The checker's torques when vertical forces on the feet carry the robot.
fn carried_torques(model: &RobotModel, posture: &Posture, loads: &[FootLoad; 2]) -> Vec<f64> {
    let mut torques = posture.gravity_torques(model);
    for (foot, load) in model.feet.iter().zip(loads) {
        let force = load.share * model.mass() * GRAVITY * DVec3::Z;
        for joint in model.chain(foot.link) {
            torques[joint] -= posture.along_joint(model, joint, load.point.extend(0.0), force);
        }
    }
    torques
}

/// The largest differences so far.
#[derive(Debug, Default)]
struct Worst {
    position: f64,
    rotation: f64,
    centre_of_mass: f64,
    torque: f64,
}

fn compare(model: &RobotModel) -> Worst {
    let robot =
        Mechanism::new(model, &PlannerConfig { effort_share: 1.0, ..PlannerConfig::default() })
            .unwrap();
    let mut kinematic_state = KinematicState::default();
    let mut worst = Worst::default();
    for index in 0..CONFIGURATIONS {
        let mut random = Random::new(1, Stream::Preparation, index, 0);
        let configuration = random_configuration(model, &mut random);
        let posture = Posture::new(model, &configuration);
        let mut q = robot.standing_q;
        q[..model.joints.len()].copy_from_slice(&configuration.q[..model.joints.len()]);
        kinematic_state.update(
            &robot,
            &planner::Configuration { world_from_root: configuration.world_from_root, q },
        );
        for (link, mine) in posture.world_from_link.iter().enumerate() {
            let other = kinematic_state.world_from_link(&robot, link);
            worst.position = worst.position.max(mine.translation.distance(other.translation));
            worst.rotation = worst.rotation.max(rotation_distance(mine.rotation, other.rotation));
        }
        let centre = kinematic_state.com;
        worst.centre_of_mass =
            worst.centre_of_mass.max(posture.centre_of_mass(model).distance(centre));
        let share = random.uniform(0.0, 1.0);
        let mut at = |share: f64| FootLoad {
            share,
            point: centre.truncate()
                + DVec2::new(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)),
        };
        let loads = [at(share), at(1.0 - share)];
        let mut torques = [0.0; JOINTS_MAX];
        write_torques(&robot.mass_tree, &kinematic_state, &loads, &mut torques);
        let mine = carried_torques(model, &posture, &loads);
        let difference =
            mine.iter().zip(torques).map(|(mine, other)| (mine - other).abs()).fold(0.0, f64::max);
        worst.torque = worst.torque.max(difference / model.mass());
    }
    worst
}

#[test]
fn planner_and_checker_agree_on_random_configurations_of_every_robot() {
    let robots = robots();
    assert!(!robots.is_empty());
    for path in robots {
        let worst = compare(&load_robot(&path).unwrap());
        println!("{}: {CONFIGURATIONS} configurations, {worst:?}", path.display());
        let poses = worst.position.max(worst.rotation).max(worst.centre_of_mass);
        assert!(poses <= POSE_MAX && worst.torque <= TORQUE_MAX, "{}: {worst:?}", path.display());
    }
}
