//! How long the planner's innermost functions take: `cargo bench --bench kernels` prints nanoseconds per call, the median
//! and the fastest of some batches.

#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::disallowed_methods, missing_docs, reason = "a command that times")]

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use surefoot_planner::body::{Body, Configuration, LINKS_MAX};
use surefoot_planner::collision::{CollisionModel, FootState};
use surefoot_planner::constraint::Constraints;
use surefoot_planner::ends::stand_on;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::kinematics::Leg;
use surefoot_planner::motion::foothold::double_mode;
use surefoot_planner::random::{Random, Stream};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scene::load::load_world;

const BATCHES: usize = 41;
const CALLS: usize = 2_000;

/// Times a function that is told which call of a batch it is.
fn time(name: &str, mut call: impl FnMut(usize)) {
    let mut nanoseconds: Vec<f64> = (0..BATCHES)
        .map(|_| {
            let begin = Instant::now();
            (0..CALLS).for_each(&mut call);
            begin.elapsed().as_secs_f64() * 1e9 / CALLS as f64
        })
        .collect();
    nanoseconds.sort_by(f64::total_cmp);
    println!("{name:<44}{:>10.0}{:>10.0}", nanoseconds[BATCHES / 2], nanoseconds[0]);
}

/// The robot with its left hip pitch axis off the point where the other hip axes meet, so that no closed form fits.
fn with_split_hip(model: &RobotModel) -> RobotModel {
    let mut model = model.clone();
    let joint = model.joints.iter().find(|joint| joint.name == "left_hip_pitch").unwrap();
    model.links[joint.child].parent.as_mut().unwrap().parent_from_joint.translation.x += 0.03;
    model
}

/// Random joint positions, and near each of them a hint and the left sole that they reach.
fn soles(model: &RobotModel, leg: &Leg) -> Vec<(Pose, Vec<f64>)> {
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let one = |_| {
        let q: Vec<f64> = model.joints.iter().map(|joint| random.uniform(joint.lower + 0.1, joint.upper - 0.1)).collect();
        let hint = q.iter().map(|position| position + random.uniform(-0.04, 0.04)).collect();
        (leg.root_from_sole(&q), hint)
    };
    (0..CALLS).map(one).collect()
}

fn time_leg(name: &str, model: &RobotModel) {
    let leg = Leg::new(model, 0, 0.0).unwrap();
    let soles = soles(model, &leg);
    let mut q = model.standing_q.clone();
    time(name, |call| {
        let (sole, hint) = &soles[call];
        q.copy_from_slice(hint);
        black_box(leg.solve(black_box(sole), &mut q));
    });
}

fn time_body(body: &Body, standing: &Configuration) {
    let mut poses = [Pose::IDENTITY; LINKS_MAX];
    time("forward kinematics", |_| {
        let at = black_box(standing);
        body.kinematics.forward(&at.world_from_root, &at.q, black_box(&mut poses));
    });
    time("centre of mass", |_| {
        black_box(body.kinematics.center_of_mass(black_box(&poses)));
    });
    time("snapshot (both)", |_| {
        black_box(body.snapshot(black_box(standing)));
    });
}

fn time_scenario(name: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenarios/{name}.toml"));
    let scenario = load_scenario(&path).unwrap();
    let (model, world) = (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let body = Body::new(&model, &scenario.planner).unwrap();
    let collision = CollisionModel::new(&model, &world, scenario.planner.clearance).unwrap();
    let constraints = Constraints { body, collision, config: scenario.planner.clone() };
    let placement = FootPlacementConfig::default();
    let mut scratch = Scratch::new(&placement);
    let surfaces = Surfaces::new(&world, placement).unwrap();
    let end = stand_on(&constraints, &surfaces, &mut scratch, &scenario.start).unwrap();
    let standing = end.state.configuration;
    let snapshot = constraints.body.snapshot(&standing);
    if name == "flat_walk" {
        time_body(&constraints.body, &standing);
        time_leg("leg inverse kinematics, closed form", &model);
        time_leg("leg inverse kinematics, Newton", &with_split_hip(&model));
    }
    let mode = double_mode(&end.footholds[0], &end.footholds[1]);
    time(&format!("configuration check, {name}"), |_| {
        black_box(constraints.check(&mode, black_box(&snapshot), [FootState::Stance; 2])).unwrap();
    });
    let sole = &model.feet[0].polygon;
    time(&format!("support query, {name}"), |_| {
        black_box(surfaces.support(&mut scratch, sole, black_box(&end.footholds[0].world_from_sole))).unwrap();
    });
}

fn main() {
    println!("{:<44}{:>10}{:>10}", "kernel", "median ns", "best ns");
    ["flat_walk", "stepping_stones", "ibeam_hallway", "ibeam_gap"].into_iter().for_each(time_scenario);
}
