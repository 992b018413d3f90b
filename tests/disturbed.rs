//! Misplaced feet and lost or delayed feedback: the walk continues with the actual feet, or the
//! robot holds its position and is planned again from there.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a test ends where a shipped scenario cannot be used")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use bytemuck::Zeroable;
use command::{assert_nothing_left, run, scenario};
use preparation::preparation_for;
use serde_json::Value;
use surefoot_controller_sim::execution::disturbance::DisturbedExecution;
use surefoot_controller_sim::{Checker, ChunkExecutor, Disturbance, Identity, Stop};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{PlanChunk, RestState, SupportMode, Waypoint, WithCrc};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;

const CONTROLLER_ID: u64 = 3;
/// Most plans of one walk.
const EPOCHS_MAX: u64 = 20;

/// How a disturbed walk went.
#[derive(Debug, Default, PartialEq)]
struct WalkStats {
    arrived: bool,
    replans: u64,
    landings: u64,
    /// The largest distance (m) and angle (rad) of a foot from its place.
    off: [f64; 2],
}

/// How far a joint may leap where a foot slides 5 mm as it lands, rad: a knee of two segments of
/// 0.38 m that is straight bends by 2 sqrt(0.005 / 0.38) = 0.23 when the ankle comes nearer by so
/// much.
const LANDING_LEAP: f64 = 0.23;

/// How much a joint's speed may leap between two chunks, rad/s: a planned stance sole may move by
/// up to 0.02 m/s, an actual one stands.
const SPEED_LEAP: f64 = 0.02;

/// The joints between the root and a foot.
fn leg_joints(model: &RobotModel, limb: usize) -> Vec<usize> {
    let attachment = |link: usize| model.links[link].parent.as_ref();
    let links = std::iter::successors(Some(model.feet[limb].link), |&link| {
        attachment(link).map(|attachment| attachment.parent)
    });
    links.filter_map(|link| attachment(link)?.joint).collect()
}

/// How far the root (m, and numbers of its rotation), the joints but these, and these (rad) lie
/// apart.
fn difference(a: &Waypoint, b: &Waypoint, of_a_leg: &[usize]) -> [f64; 3] {
    let root =
        |w: &Waypoint| w.root_position.into_iter().chain(w.root_rotation).collect::<Vec<f64>>();
    let apart = |(x, y): (&f64, &f64)| (x - y).abs();
    let most = |among: &dyn Fn(usize) -> bool| {
        (0..a.q.len())
            .filter(|&joint| among(joint))
            .map(|joint| apart((&a.q[joint], &b.q[joint])))
            .fold(0.0, f64::max)
    };
    let moved = root(a).iter().zip(&root(b)).map(apart).fold(0.0, f64::max);
    [moved, most(&|joint| !of_a_leg.contains(&joint)), most(&|joint| of_a_leg.contains(&joint))]
}

/// The largest difference of the speeds of the root and of all joints but these, m/s or rad/s.
fn speed_difference(a: &Waypoint, b: &Waypoint, of_a_leg: &[usize]) -> f64 {
    let joints = (0..a.q.len()).filter(|joint| !of_a_leg.contains(joint));
    let joints = joints.map(|joint| a.joint_velocity[joint] - b.joint_velocity[joint]);
    let root = a.root_velocity.iter().zip(&b.root_velocity).map(|(x, y)| x - y);
    joints.chain(root).map(f64::abs).fold(0.0, f64::max)
}

/// Walks one plan until its end or until it does not fit; where the robot stands then. Every
/// executed chunk begins where the one before ended, and as fast, except that the leg of a landing
/// foot follows its slide.
fn walk_plan(
    model: &RobotModel,
    executor: &mut ChunkExecutor,
    disturbance: &mut Disturbance,
    chunks: &[PlanChunk],
    rest_state: &mut RestState,
    stats: &mut WalkStats,
) {
    let mut end = rest_state.waypoint;
    for chunk in chunks {
        let mut chunk = PlanChunk { target_controller: CONTROLLER_ID, session: 1, ..*chunk };
        chunk.write_crc();
        executor
            .check_chunk(&chunk, &mut || {})
            .unwrap_or_else(|violation| panic!("chunk {}: {violation}", chunk.sequence));
        let landing =
            executor.landing(&chunk).map(|contact| leg_joints(model, contact.limb as usize));
        let DisturbedExecution::Executed(actual, _) =
            disturbance.execute(executor, &chunk, &mut || {})
        else {
            executor.hold_position();
            stats.replans += 1;
            return;
        };
        stats.landings += u64::from(landing.is_some());
        if rest_state.is_known() {
            let (begin, leg) = (&actual.waypoints()[0], landing.unwrap_or_default());
            let [root, joint, of_leg] = difference(&end, begin, &leg);
            let differs =
                format!("root {root:.1e}, joint {joint:.1e}, of the leg that lands {of_leg:.1e}");
            assert!(
                root < 1e-6 && joint < 1e-6 && of_leg < LANDING_LEAP,
                "chunk {}: {differs}",
                chunk.sequence
            );
            let faster = speed_difference(&end, begin, &leg);
            assert!(faster < SPEED_LEAP, "chunk {}: {faster:.1e}", chunk.sequence);
        }
        for (planned, stands) in chunk.contacts().iter().zip(actual.contacts()) {
            let (a, b) = (planned.world_from_sole(), stands.world_from_sole());
            let off =
                [a.translation.distance(b.translation), rotation_distance(a.rotation, b.rotation)];
            stats.off = [stats.off[0].max(off[0]), stats.off[1].max(off[1])];
        }
        end = *actual.waypoints().last().unwrap();
        let rest = Stop::rest(&actual);
        *rest_state = rest_state.after(actual.mode, actual.contacts(), &rest);
    }
}

/// A disturbed walk of a scenario.
fn walk(name: &str, motion: MotionKind, seed: u64) -> WalkStats {
    let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
    let scenario = scenario.with_motion(motion);
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let identity = Identity {
        controller_id: CONTROLLER_ID,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let mut executor = ChunkExecutor::new(
        Checker::new(model.clone(), world.clone(), scenario.checker.clone()).unwrap(),
        identity,
    );
    let mut disturbance = Disturbance::new(seed);
    let (mut rest_state, mut stats) = (RestState::zeroed(), WalkStats::default());
    for epoch in 0..EPOCHS_MAX {
        let start = rest_state.stance_pose().unwrap_or(scenario.start);
        let scenario = Scenario { start, ..scenario.clone() };
        let preparation = preparation_for(&model, &scenario.planner);
        let mut builder =
            Planner::builder(&model, &world, &scenario, preparation).plan_name(1, epoch);
        if rest_state.is_known() {
            builder = builder.start_in(&rest_state);
        }
        let mut planner = builder.build().unwrap();
        if planner.step(u64::MAX) != Status::Done(Outcome::Found) {
            return stats;
        }
        walk_plan(
            &model,
            &mut executor,
            &mut disturbance,
            planner.chunks(),
            &mut rest_state,
            &mut stats,
        );
        if executor.finished() {
            return WalkStats { arrived: true, ..stats };
        }
    }
    stats
}

#[test]
fn the_robot_arrives_with_misplaced_feet() {
    let mut arrived = 0;
    for name in ["flat_walk", "stepping_stones", "ibeam_gap"] {
        for seed in 1..=3 {
            let stats = walk(name, MotionKind::QuasiStatic, seed);
            println!("{name} {seed}: {stats:?}");
            let [off, turn] = stats.off;
            assert!(stats.landings > 3 && off > 0.002 && off < 0.00501, "{stats:?}");
            assert!(turn > 0.2_f64.to_radians() && turn < 1.001_f64.to_radians(), "{stats:?}");
            arrived += u64::from(stats.arrived);
            assert!(stats.arrived || name != "flat_walk", "flat ground supports a sole everywhere");
        }
    }
    assert!(arrived >= 7, "{arrived} of 9 arrived");
}

#[test]
fn the_robot_goes_on_in_smooth_motion_with_misplaced_feet() {
    let mut replans = 0;
    for (name, seed) in [("stepping_stones", 1), ("stepping_stones", 2), ("beam", 1)] {
        let stats = walk(name, MotionKind::Smooth, seed);
        println!("{name} {seed}: {stats:?}");
        let [off, turn] = stats.off;
        assert!(stats.arrived && stats.landings > 3 && off > 0.002 && off < 0.00501, "{stats:?}");
        assert!(turn > 0.2_f64.to_radians() && turn < 1.001_f64.to_radians(), "{stats:?}");
        replans += stats.replans;
    }
    // The legs compensate: a rest and a new plan after each landing would be one for each.
    assert!(replans <= 3, "{replans}");
}

#[test]
fn disturbances_are_reproducible_by_their_seed() {
    for (name, motion) in [("flat_walk", MotionKind::QuasiStatic), ("beam", MotionKind::Smooth)] {
        let [first, again, other] = [4, 4, 5].map(|seed| walk(name, motion, seed));
        assert_eq!(first, again);
        assert_ne!(first.off, other.off);
    }
}

#[test]
fn a_misplaced_last_step_ends_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let (path, json) = (short_walk(folder.path()), folder.path().join("report.json"));
    for seed in ["1", "2", "3"] {
        let mut line = vec!["walk", &path, "--quiet", "--motion", "smooth"];
        line.extend(["--disturb", seed, "--json", json.to_str().unwrap()]);
        let output = run(&line);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        assert_eq!(report["replans"], 0, "{report}");
    }
}

/// A walk of 0.6 m over level ground, in a folder.
fn short_walk(folder: &std::path::Path) -> String {
    let path = folder.join("short.toml");
    let configs = concat!(env!("CARGO_MANIFEST_DIR"), "/configs");
    let text = format!(
        "robot = \"{configs}/robots/hubo/robot.toml\"\nworld = \"{configs}/worlds/flat_walk.toml\"\n\
         [start]\nxyz = [0.5, 0, 0]\n[goal]\nxyz = [1.1, 0, 0]\n[planner]\nwork_max = 20000\n"
    );
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn from_a_foot_that_landed_beside_the_goal_the_last_step_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = load_scenario(short_walk(folder.path()).as_ref()).unwrap();
    let model = load_robot(&scenario.robot_path).unwrap();
    let world = load_world(&scenario.world_path).unwrap();
    let plan = |rest_state: Option<&RestState>| {
        let start = rest_state.and_then(RestState::stance_pose).unwrap_or(scenario.start);
        let scenario = Scenario { start, ..scenario.clone() };
        let preparation = preparation_for(&model, &scenario.planner);
        let mut builder = Planner::builder(&model, &world, &scenario, preparation);
        if let Some(rest_state) = rest_state {
            builder = builder.start_in(rest_state);
        }
        let mut planner = builder.build().unwrap();
        let status = planner.step(u64::MAX);
        (status, planner.chunks().to_vec())
    };
    let (_, chunks) = plan(None);
    for seed in 1..=12 {
        let identity = Identity {
            controller_id: CONTROLLER_ID,
            robot: model.digest,
            world: world.digest,
            config: scenario.digest,
        };
        let checker = Checker::new(model.clone(), world.clone(), scenario.checker.clone()).unwrap();
        let (mut executor, mut disturbance) =
            (ChunkExecutor::new(checker, identity), Disturbance::new(seed));
        let (mut rest_state, mut stats) = (RestState::zeroed(), WalkStats::default());
        walk_plan(
            &model,
            &mut executor,
            &mut disturbance,
            &chunks[..chunks.len() - 1],
            &mut rest_state,
            &mut stats,
        );
        assert_eq!((stats.replans, rest_state.mode), (0, SupportMode::Left as u32), "seed {seed}");
        assert_eq!(plan(Some(&rest_state)).0, Status::Done(Outcome::Found), "seed {seed}");
    }
}

#[test]
fn the_check_refuses_a_motion_executed_with_misplaced_feet_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let (scenario, walked) = (short_walk(folder.path()), folder.path().join("walked.json"));
    let walked = walked.to_str().unwrap();
    let output = run(&["walk", &scenario, "--quiet", "--disturb", "3", "--executed", walked]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let checked = run(&["check", walked]);
    let lines: Vec<&str> = checked.err.lines().collect();
    assert_eq!((checked.code, checked.out.as_str(), lines.len()), (2, "", 1), "{}", checked.err);
    assert!(lines[0].contains("disturb_seed") && lines[0].contains("--disturb 3"), "{}", lines[0]);
    let undisturbed = run(&["walk", &scenario, "--quiet", "--executed", walked]);
    assert_eq!(undisturbed.code, 0, "{}", undisturbed.err);
    assert_eq!(run(&["check", walked]).code, 0, "a walk without misplaced feet is checked");
}

#[test]
fn a_disturbed_walk_of_two_processes_loses_nothing() {
    let walked = |motion: &str, seed: &str| {
        let folder = tempfile::tempdir().unwrap();
        let json = folder.path().join("report.json");
        let output = run(&[
            "walk",
            &scenario("stepping_stones"),
            "--quiet",
            "--motion",
            motion,
            "--disturb",
            seed,
            "--json",
            json.to_str().unwrap(),
        ]);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        assert_nothing_left(output.pid);
        let report: Value = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
        let count = |what: &str| report["chunks"][what].as_u64().unwrap();
        assert_eq!(
            (report["outcome"].as_str(), count("lost"), count("duplicated")),
            (Some("accepted"), 0, 0),
            "{report}"
        );
        (report["digest"].clone(), report["replans"].clone(), report["margins"].clone())
    };
    for motion in ["quasi_static", "smooth"] {
        let [first, again, other] = ["1", "1", "2"].map(|seed| walked(motion, seed));
        assert_eq!(first, again);
        assert_ne!(first.2, other.2);
    }
}
