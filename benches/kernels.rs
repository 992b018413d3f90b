//! Times of the planner's layers, from forward kinematics to single-mode planning.
//! `cargo bench --bench kernels [-- --json]` prints nanoseconds per call (median and fastest batch)
//! and work units per call. `-- --robot ROBOT.toml` measures another robot, on the flat floor only.
//! `--bench plan` measures whole plans.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    missing_docs,
    reason = "a benchmark command"
)]

#[path = "kernels/dump.rs"]
mod dump;
#[path = "kernels/scene.rs"]
mod scene;
#[path = "kernels/timing.rs"]
mod timing;

use std::hint::black_box;
use std::path::Path;

use glam::DVec3;
use scene::{SEED, Scene, cluttered, shipped};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::FootPhase;
use surefoot_planner::constraints::foothold::single_mode;
use surefoot_planner::foot_placement::{PlacementQuery, SampleLimits, SoleShape, propose};
use surefoot_planner::kinematics::Leg;
use surefoot_planner::motion::cbirrt::SingleModeProblem;
use surefoot_planner::motion::cbirrt::nearest;
use surefoot_planner::motion::single_mode::solve;
use surefoot_planner::motion::tree_pool::TreeNode;
use surefoot_planner::motion::workspace::Workspace;
use surefoot_planner::primitives::transition_configuration::sample;
use surefoot_planner::primitives::transition_pair::TransitionPair;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::configuration::midway;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use timing::{Kernel, time};

/// The measured scenarios, as far as they exist.
const SCENARIOS: [&str; 5] =
    ["flat_walk", "stepping_stones", "ibeam_hallway", "ibeam_gap", "cinder_blocks"];
/// Shapes of the cluttered world.
const CLUTTER: usize = 60;
/// Different leg poses in a batch.
const POSES: usize = 2_048;
/// Nodes of the tree of the nearest-neighbour search.
const NODES: usize = 512;

/// The robot with its left hip pitch axis moved off the intersection of the other hip axes, so that
/// no closed form applies.
fn with_split_hip(model: &RobotModel) -> Option<RobotModel> {
    let mut model = model.clone();
    let child = model.joints.iter().find(|joint| joint.name == "left_hip_pitch")?.child;
    model.links[child].parent.as_mut().unwrap().parent_from_joint.translation.x += 0.03;
    Some(model)
}

/// Sole poses at random joint positions, each with an initial guess of the joint positions.
fn soles(model: &RobotModel, leg: &Leg) -> Vec<(Pose, Vec<f64>)> {
    let mut random = Random::new(SEED, Stream::Preparation, 0, 0);
    let one = |_| {
        let q: Vec<f64> = model
            .joints
            .iter()
            .map(|joint| random.uniform(0.95 * joint.lower, 0.95 * joint.upper))
            .collect();
        let guess = q.iter().map(|position| position + random.uniform(-0.04, 0.04)).collect();
        (leg.root_from_sole(&q), guess)
    };
    (0..POSES).map(one).collect()
}

fn time_leg(name: &str, model: &RobotModel) -> Kernel {
    let leg = Leg::new(model, 0, 0.0).unwrap();
    let soles = soles(model, &leg);
    let mut q = model.standing_q.clone();
    time(name, |call| {
        let (sole, guess) = &soles[call % POSES];
        q.copy_from_slice(guess);
        black_box(leg.solve(black_box(sole), &mut q));
        0
    })
}

/// Kernels that depend on the robot alone.
fn time_robot(scene: &Scene) -> Vec<Kernel> {
    let (robot, standing) = (&scene.constraints.robot, scene.standing());
    let mut state = scene.kinematic_state.clone();
    let whole = time("kinematic state: forward kinematics, centre of mass", |call| {
        let mut at = *black_box(standing);
        // Every joint moves, also the upper body.
        at.q[..robot.joints_len]
            .iter_mut()
            .for_each(|position| *position += 1e-3 * (call % 2) as f64);
        black_box(&mut state).update(robot, &at);
        0
    });
    let legs = time("kinematic state, only the legs moved", |_| {
        black_box(&mut state).update(robot, black_box(standing));
        0
    });
    let leg = time_leg("leg inverse kinematics", &scene.model);
    let newton = with_split_hip(&scene.model)
        .map(|model| time_leg("leg inverse kinematics, Newton", &model));
    [whole, legs, leg].into_iter().chain(newton).collect()
}

/// Kernels that depend on the robot and the world.
fn time_checks(name: &str, scene: &Scene) -> Vec<Kernel> {
    let (constraints, feet) = (&scene.constraints, [FootPhase::Stance; 2]);
    let mode = scene.standing_mode();
    let shapes = format!("{} shapes", scene.world.shapes.len());
    let check = time(format!("{name}: configuration check, kinematics given"), |_| {
        constraints.check(&mode, black_box(&scene.kinematic_state), feet).unwrap();
        0
    });
    let soles = scene.end.state.world_from_soles;
    let mut kinematic_state = scene.kinematic_state.clone();
    let mut whole = |what: &str, arms: f64| {
        time(format!("{name}: configuration check with IK and FK, {what}"), |call| {
            let mut at = *black_box(scene.standing());
            // A slightly different pose in each call, against branch prediction.
            at.world_from_root.translation.z -= 1e-4 * (call % 64) as f64;
            constraints
                .robot
                .free_joints
                .iter()
                .for_each(|joint| at.q[joint.index] += arms * (call % 64) as f64);
            assert!(constraints.robot.place_soles(&mut at, &soles));
            kinematic_state.update(&constraints.robot, &at);
            constraints.check(&mode, &kinematic_state, feet).unwrap();
            0
        })
    };
    let [arms_fixed, whole] = [whole("arms fixed", 0.0), whole("all moves", 1e-4)];
    let mut aside = *scene.standing();
    aside.world_from_root.translation.z -= 0.01;
    assert!(constraints.robot.place_soles(&mut aside, &soles));
    let (from, to) = (scene.standing(), midway(scene.standing(), &aside, 1.0));
    let reached = KinematicState::new(&constraints.robot, &to);
    let mut between = 0;
    let edge = time(format!("{name}: edge check, root 1 cm down"), |_| {
        let bound = constraints
            .collision
            .motion_bound(black_box(&scene.kinematic_state), black_box(&reached));
        between = constraints
            .check_between(&mode, black_box([from, &to]), bound, feet, &mut kinematic_state)
            .unwrap();
        0
    });
    let edge = edge.noted(format!("{shapes}, {between} configurations"));
    [check, arms_fixed, whole]
        .map(|kernel| kernel.noted(shapes.clone()))
        .into_iter()
        .chain([edge])
        .collect()
}

fn time_footholds(name: &str, scene: &mut Scene) -> Vec<Kernel> {
    let Scene { constraints, surfaces, scratch, end, model, .. } = scene;
    let sole = &model.feet[0].polygon;
    let at = end.footholds[0].world_from_sole;
    let support = time(format!("{name}: foothold query, one pose"), |_| {
        black_box(surfaces.support(scratch, sole, black_box(&at))).unwrap();
        0
    });
    let is_free =
        |pose: &Pose| constraints.collision.foot_hit(0, pose, FootPhase::Stance).is_none();
    let mut found = 0;
    let limits = SampleLimits { geometric_max: 48, perturbed_max: 8, sampled_max: 60 };
    let propose = time(format!("{name}: foothold query, all within 0.35 m"), |call| {
        let query = PlacementQuery {
            ideal: at,
            sole: SoleShape::flat(sole),
            reach_xy: 0.35,
            reach_z: [-0.6, 0.6],
            yaw_spread: 0.8,
            seed: SEED,
            object: call as u64,
            attempt: 0,
            limits,
            is_free: &is_free,
        };
        found = 0;
        propose(surfaces, scratch, &query, &mut |_| {
            found += 1;
            true
        });
        0
    });
    vec![support, propose.noted(format!("{found} placements"))]
}

fn time_transitions(name: &str, scene: &Scene) -> Kernel {
    let [left, right] = &scene.end.footholds;
    let (mode, pair) = (single_mode(left), TransitionPair { stance: left, other: right });
    let (mut valid, mut tried) = (0_u64, 0_u64);
    let kernel = time(format!("{name}: transition sample, uniform"), |call| {
        // Attempts after the primitive postures and their neighbourhood are uniform.
        let found = sample(&scene.constraints, &mode, pair, (SEED, 1), 1_000 + call as u64);
        tried += 1;
        valid += u64::from(found.is_ok());
        1
    });
    with_success_rate(kernel, valid, tried)
}

/// Random postures over both stance feet: the root within 3 cm and 0.1 rad of the standing posture
/// and up to 6 cm lower, every free joint within 0.1 rad.
fn time_stances(name: &str, scene: &Scene) -> Kernel {
    let (constraints, mode) = (&scene.constraints, scene.standing_mode());
    let (robot, soles) = (&constraints.robot, scene.end.state.world_from_soles);
    let mut random = Random::new(SEED, Stream::Preparation, 1, 0);
    let mut posture = |_| {
        let mut at = *scene.standing();
        let mut vector =
            |half: f64| DVec3::from_array(std::array::from_fn(|_| random.uniform(-half, half)));
        at.world_from_root.translation += vector(0.03) - DVec3::Z * 0.03;
        at.world_from_root.rotation =
            rotation_from_scaled_axis(vector(0.1)) * at.world_from_root.rotation;
        for joint in &robot.free_joints {
            at.q[joint.index] =
                (at.q[joint.index] + random.uniform(-0.1, 0.1)).clamp(joint.lower, joint.upper);
        }
        at
    };
    let postures: Vec<Configuration> = (0..POSES).map(&mut posture).collect();
    let mut kinematic_state = scene.kinematic_state.clone();
    let (mut valid, mut tried) = (0_u64, 0_u64);
    let kernel = time(format!("{name}: random stance on both feet, checked"), |_| {
        let mut at = *black_box(&postures[tried as usize % POSES]);
        tried += 1;
        if robot.place_soles(&mut at, &soles) {
            kinematic_state.update(robot, &at);
            valid += u64::from(
                constraints.check(&mode, &kinematic_state, [FootPhase::Stance; 2]).is_ok(),
            );
        }
        0
    });
    with_success_rate(kernel, valid, tried)
}

/// The kernel with its valid results per second.
fn with_success_rate(kernel: Kernel, valid: u64, tried: u64) -> Kernel {
    let share = valid as f64 / tried as f64;
    let per_second = share * 1e9 / kernel.median_ns;
    Kernel {
        per_second: Some(per_second),
        ..kernel.noted(format!("{:.0} % valid: {per_second:.0}/s", 100.0 * share))
    }
}

fn time_motion(name: &str, scene: &Scene, problem: &SingleModeProblem) -> Kernel {
    let mut workspace = Workspace::new(1024, 1536);
    let kernel =
        time(name, |_| solve(&scene.constraints, black_box(problem), &mut workspace).unwrap());
    kernel.noted(format!("{} waypoints", workspace.path.len()))
}

fn time_step(name: &str, scene: &mut Scene) -> Vec<Kernel> {
    let Some(step) = scene.step() else { return vec![] };
    let swing = step.swing();
    let mut random = Random::new(SEED, Stream::SingleMode, 0, 0);
    let node = |_| {
        let mut state = swing.from;
        state.configuration.world_from_root.translation.x += random.uniform(-0.1, 0.1);
        state.world_from_soles[0].translation.x += random.uniform(-0.2, 0.2);
        TreeNode { state, parent: 0 }
    };
    let nodes: Vec<TreeNode> = (0..NODES).map(node).collect();
    let nearest = time(format!("{name}: nearest neighbour of {NODES}"), |_| {
        black_box(nearest(&nodes, &swing, black_box(&swing.to)));
        0
    });
    let shift =
        time_motion(&format!("{name}: single-mode plan, weight shift"), scene, &step.shift());
    let swing = time_motion(&format!("{name}: single-mode plan, swing"), scene, &swing);
    vec![nearest, shift, swing]
}

fn time_scenario(name: &str, mut scene: Scene) -> Vec<Kernel> {
    let mut kernels = time_checks(name, &scene);
    kernels.extend(time_footholds(name, &mut scene));
    kernels.push(time_transitions(name, &scene));
    kernels.push(time_stances(name, &scene));
    kernels.extend(time_step(name, &mut scene));
    kernels
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |option: &str| {
        arguments
            .iter()
            .position(|argument| argument == option)
            .and_then(|at| arguments.get(at + 1))
    };
    let mut flat = shipped("flat_walk");
    let robot = after("--robot");
    if let Some(path) = robot {
        flat.model = load_robot(Path::new(path)).unwrap();
    }
    let mut kernels = time_robot(&Scene::new(flat.clone()));
    kernels.extend(time_checks("clutter", &Scene::new(cluttered(flat.clone(), CLUTTER))));
    if robot.is_some() {
        kernels.extend(time_scenario("flat_walk", Scene::new(flat.clone())));
    } else {
        let is_shipped = |name: &&str| {
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join(format!("configs/scenarios/{name}.toml"))
                .exists()
        };
        for name in SCENARIOS.into_iter().filter(is_shipped) {
            kernels.extend(time_scenario(name, Scene::new(shipped(name))));
        }
    }
    if arguments.iter().any(|argument| argument == "--json") {
        let report = serde_json::json!({ "schema": "surefoot-bench-kernels/1", "kernels": kernels, "problem": dump::problem(&mut Scene::new(flat)) });
        println!("{}", serde_json::to_string_pretty(&report).unwrap());
    } else {
        println!("{:<52}{:>12}{:>12}{:>10}", "kernel", "median ns", "best ns", "work");
        kernels.iter().for_each(|kernel| println!("{}", kernel.line()));
    }
}
