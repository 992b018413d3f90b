//! A plan is saved, loaded and checked again through the library alone.

#![allow(clippy::unwrap_used, reason = "a call that fails fails the test")]

use std::path::{Path, PathBuf};

use glam::DVec3;
use surefoot::{
    Checker, Goal, HeightMap, MotionKind, Parameters, Plan, PlanChunk, Planner, Pose, Prepared,
    Robot, Shape, Stance, World,
};

const START: Stance = Stance::at(0.0, 0.0, 0.0);
const GOAL: Goal = Goal::at(0.6, 0.0, 0.0);

fn robot() -> Robot {
    Robot::load("configs/robots/hubo/robot.toml").unwrap()
}

/// A floor with an edge, as a mesh in memory.
fn ground() -> World {
    let heights = [0.0; 2 * 3];
    let map = HeightMap { heights: &heights, columns: 3, spacing: 1.0 };
    World::builder()
        .height_map("ground", Pose::at(-0.5, -0.5, 0.0), &map)
        .shape("post", Pose::at(0.3, 1.5, 0.5), Shape::cylinder(0.1, 1.0))
        .build()
        .unwrap()
}

/// The folder in which the program keeps preparations for all tests.
fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("surefoot")
}

fn plan(robot: &Robot, world: &World) -> Plan {
    plan_with(robot, world, &Parameters::default())
}

fn plan_with(robot: &Robot, world: &World, parameters: &Parameters) -> Plan {
    let prepared = Prepared::in_folder(robot, parameters, cache()).unwrap();
    let builder = Planner::builder(&prepared, world).parameters(parameters.clone());
    builder.build().unwrap().plan(START, GOAL).unwrap()
}

#[test]
fn a_preparation_is_read_from_its_folder_and_a_damaged_one_is_made_anew() {
    let robot = robot();
    let parameters = Parameters::default();
    let bytes_in = |folder: &Path| {
        let mut bytes = vec![];
        Prepared::in_folder(&robot, &parameters, folder).unwrap().write(&mut bytes).unwrap();
        bytes
    };
    let bytes = bytes_in(&cache());
    let is_ours = |path: &PathBuf| std::fs::read(path).is_ok_and(|found| found == bytes);
    let files = std::fs::read_dir(cache()).unwrap().map(|entry| entry.unwrap().path());
    let saved = files.into_iter().find(is_ours).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(saved.file_name().unwrap());
    std::fs::write(&copy, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(bytes_in(folder.path()), bytes);
    assert_eq!(std::fs::read(&copy).unwrap(), bytes);
}

#[test]
fn a_loaded_plan_is_the_saved_motion_in_the_same_world() {
    let (robot, world) = (robot(), ground());
    let plan = plan(&robot, &world);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.json");
    plan.save(&path).unwrap();
    assert!(folder.path().join("walk.0.obj").is_file());
    let loaded = Plan::load(&path).unwrap();
    assert_eq!(loaded.duration(), plan.duration());
    let places = |plan: &Plan| -> Vec<_> {
        plan.footholds().iter().map(|one| (one.foot, one.time, one.position)).collect()
    };
    assert_eq!(places(&loaded), places(&plan));
    for share in 0..=20 {
        let time = plan.duration() * f64::from(share) / 20.0;
        let (saved, read) = (plan.sample(time), loaded.sample(time));
        assert_eq!((saved.q, saved.world_from_root), (read.q, read.world_from_root));
        assert_eq!(saved.contacts.footholds.len(), read.contacts.footholds.len());
    }
    assert_eq!(loaded.world().shape_names().collect::<Vec<_>>(), ["ground", "post"]);
    assert!(Checker::check_file(&path).unwrap().is_valid());
    let again = folder.path().join("again.json");
    loaded.save(&again).unwrap();
    assert_eq!(Plan::load(&again).unwrap().digest(), loaded.digest());
}

#[test]
fn a_chunk_whose_form_is_not_sound_is_refused_before_its_motion_is_looked_at() {
    let (robot, world) = (robot(), ground());
    let plan = plan(&robot, &world);
    let mut checker = Checker::new(&robot, &world, &Parameters::default()).unwrap();
    checker.check_plan(&plan).unwrap();
    type Change = (&'static str, fn(&mut PlanChunk));
    let changes: [Change; 7] = [
        ("mode", |chunk| chunk.mode = 9),
        ("contacts", |chunk| chunk.contacts[0].limb = 7),
        ("contacts", |chunk| chunk.contacts_len = 1),
        ("joints", |chunk| chunk.joints_len = 3),
        ("waypoints", |chunk| chunk.waypoints_len = 0),
        ("waypoint", |chunk| chunk.waypoints[0].q[0] = f64::NAN),
        ("ramps", |chunk| chunk.brake_duration = f64::NAN),
    ];
    for (part, change) in changes {
        let mut chunk = plan.chunks()[0];
        change(&mut chunk);
        let violation = checker.check(&chunk).unwrap_err();
        assert_eq!(violation.check.name(), "malformed", "{violation}");
        assert!(violation.detail.contains(part), "{violation}");
    }
}

#[test]
fn a_plan_is_checked_as_an_answer_to_a_task() {
    let (robot, world) = (robot(), ground());
    let plan = plan(&robot, &world);
    let checker = Checker::new(&robot, &world, &Parameters::default()).unwrap();
    assert!(checker.answer(&plan, START, GOAL).unwrap().is_valid());
    assert!(checker.answer_as_stated(&plan).unwrap().is_valid());
    let report = checker.answer(&plan, START, Goal::at(2.0, 0.0, 0.0)).unwrap();
    assert!(report.violations().next().is_none() && report.goal.violation.is_some());
    let low = World::builder()
        .shape("floor", Pose::at(0.0, 0.0, -0.6), Shape::cuboid([3.0, 3.0, 0.5]))
        .build()
        .unwrap();
    let checker = Checker::new(&robot, &low, &Parameters::default()).unwrap();
    assert!(checker.answer(&plan, START, GOAL).unwrap().violations().next().is_some());
}

#[test]
fn the_loads_of_a_smooth_plan_move_the_robot_as_planned() {
    let (robot, world) = (robot(), ground());
    let mut parameters = Parameters::default();
    parameters.execution.motion = MotionKind::Smooth;
    let plan = plan_with(&robot, &world, &parameters);
    let mut checker = Checker::new(&robot, &world, &parameters).unwrap();
    let (mass, step) = (robot.mass(), 1e-3);
    let (mut moves, mut compared) = (0.0_f64, 0);
    let smooth = plan.chunks().iter().filter(|chunk| chunk.is_smooth());
    for waypoint in smooth.flat_map(PlanChunk::waypoints) {
        let load = checker.load(&plan, waypoint.time);
        let force: DVec3 = load.feet.iter().map(|foot| DVec3::from(foot.force)).sum();
        if waypoint.time < step || waypoint.time > plan.duration() - step {
            continue;
        }
        let [before, here, after] = [-step, 0.0, step]
            .map(|later| DVec3::from(checker.load(&plan, waypoint.time + later).centre_of_mass));
        let acceleration = (after - 2.0 * here + before) / (step * step);
        let wanted = mass * (acceleration + 9.81 * DVec3::Z);
        assert!(force.distance(wanted) < 0.02 * mass, "{force} {wanted} at {} s", load.time);
        moves = moves.max(acceleration.length());
        // On one foot the wrench is given, and with it the torques: those that the planner found.
        if load.feet.len() == 1 {
            let planned = plan.sample(waypoint.time).torque;
            let off = planned.iter().zip(&load.torques).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < 1e-3, "{off} N m at {} s", load.time);
            compared += 1;
        }
    }
    assert!(moves > 0.3 && compared > 50, "{moves} {compared}");
}

#[test]
fn the_loads_carry_the_weight_on_the_stance_feet() {
    let (robot, world) = (robot(), ground());
    let mut parameters = Parameters::default();
    parameters.execution.motion = MotionKind::QuasiStatic;
    let plan = plan_with(&robot, &world, &parameters);
    let mut checker = Checker::new(&robot, &world, &parameters).unwrap();
    let loads = checker.loads(&plan, 0.1);
    assert!(loads.len() as f64 >= plan.duration() / 0.1);
    assert_eq!(loads.last().unwrap().time, plan.duration());
    let weight = robot.mass() * 9.81;
    for load in &loads {
        let carried: f64 = load.feet.iter().map(|foot| foot.force[2]).sum();
        assert!((carried - weight).abs() < 1e-6 * weight, "{carried} N of {weight} N");
        let is_stance = |foot| plan.contacts_at(load.time).is_stance(foot);
        assert!(load.feet.iter().all(|foot| is_stance(foot.foot)), "at {} s", load.time);
        assert!(load.balance_margin > 0.0 && load.torques.len() == 27);
    }
}
