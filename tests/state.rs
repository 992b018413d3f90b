//! The simulated walk: what the state service publishes at every tick, and that no subscriber slows
//! the pair.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::fs;
use std::path::Path;
use std::time::Duration;

use command::{CommandOutput, finish, scenario, surefoot};
use glam::DVec3;
use preparation::preparation_for;
use surefoot_controller_sim::execution::simulation::Simulation;
use surefoot_controller_sim::{Checker, ChunkExecutor, ChunkWalk, Identity, StopCounts};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::message::{PlanChunk, SimulationState, SupportMode, WithCrc};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::GRAVITY;

const CONTROLLER_ID: u64 = 3;
const TICK: f64 = 0.01;

/// Walks a scenario in simulated time; the states of all ticks.
fn simulate(name: &str) -> (RobotModel, Vec<PlanChunk>, Vec<SimulationState>) {
    let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
    let scenario = scenario.with_motion(MotionKind::QuasiStatic);
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let mut planner =
        Planner::builder(&model, &world, &scenario, preparation_for(&model, &scenario.planner))
            .build()
            .unwrap();
    assert_eq!(planner.step(u64::MAX), Status::Done(Outcome::Found));
    let identity = Identity {
        controller_id: CONTROLLER_ID,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let mut executor =
        ChunkExecutor::new(Checker::new(model.clone(), world, scenario.checker).unwrap(), identity);
    let (mut simulation, mut walk) = (Simulation::new(CONTROLLER_ID, TICK), ChunkWalk::default());
    for chunk in planner.chunks() {
        let mut chunk = PlanChunk { target_controller: CONTROLLER_ID, session: 1, ..*chunk };
        chunk.write_crc();
        executor.check_and_execute(&chunk).unwrap();
        walk.accept(&chunk);
    }
    let mut states = vec![simulation.state(executor.checker_mut(), &walk).unwrap()];
    while !walk.is_finished() {
        walk.advance(TICK);
        states.push(simulation.state(executor.checker_mut(), &walk).unwrap());
    }
    assert_eq!(walk.counts(), StopCounts::default());
    (model, planner.chunks().to_vec(), states)
}

/// Every multiple of the tick within `seconds`, each once and in order, and the end.
fn assert_every_instant(states: &[SimulationState], seconds: f64) {
    let instants = (seconds / TICK).floor() as usize + 1;
    assert!(
        (instants..=instants + 1).contains(&states.len()),
        "{} states, {instants} instants",
        states.len()
    );
    for (index, state) in states.iter().enumerate() {
        assert!(state.is_well_formed());
        assert_eq!(state.tick, index as u64 + 1);
        let wanted = (index as f64 * TICK).min(seconds);
        assert!(
            (state.waypoint.time - wanted).abs() < 1e-9,
            "{} at tick {}",
            state.waypoint.time,
            state.tick
        );
    }
}

fn end_of(chunks: &[PlanChunk]) -> f64 {
    chunks.last().unwrap().waypoints().last().unwrap().time
}

#[test]
fn the_forces_of_every_tick_hold_the_robot() {
    let (model, chunks, states) = simulate("ibeam_gap");
    assert_every_instant(&states, end_of(&chunks));
    let weight = model.mass() * GRAVITY;
    let mut modes = [0; 3];
    for state in &states {
        let mode = SupportMode::from_wire(state.mode).unwrap();
        modes[mode as usize] += 1;
        assert_eq!(state.feet().len(), if mode == SupportMode::Double { 2 } else { 1 });
        let force: DVec3 = state.feet().iter().map(|foot| DVec3::from(foot.force)).sum();
        assert!(force.distance(weight * DVec3::Z) < 1e-3, "{force} at tick {}", state.tick);
        // The torques about the origin of the forces and of the weight; level soles press at their
        // centres.
        let turn: DVec3 = state
            .feet()
            .iter()
            .map(|foot| DVec3::from(foot.centre).cross(DVec3::from(foot.force)))
            .sum();
        let off = turn + DVec3::from(state.centre_of_mass).cross(-weight * DVec3::Z);
        assert!(off.x.abs() < 0.01 && off.y.abs() < 0.01, "{off} at tick {}", state.tick);
        assert!(
            state.balance_margin > 0.0 && (0.0..=1.0).contains(&state.friction_use),
            "{state:?}"
        );
        assert!(state.torque_use > 0.0 && state.torque_use < 1.0, "{}", state.torque_use);
    }
    assert!(modes.iter().all(|ticks| *ticks > 0), "{modes:?}");
}

/// A scenario of a metre on flat ground.
fn short_walk(folder: &Path) -> String {
    let configs = format!("\"{}/configs/", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(scenario("flat_walk")).unwrap();
    let file = folder.join("short.toml");
    let text = text.replace("\"../", &configs).replace("[9.5, 0.0, 0.0]", "[1.5, 0.0, 0.0]");
    assert!(text.contains("[1.5, 0.0, 0.0]"));
    fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Runs both roles by hand, the controller in simulated time; their outputs.
fn walk_by_hand(
    name: &str,
    file: &str,
    rate: &str,
    mut meanwhile: impl FnMut(),
) -> [CommandOutput; 2] {
    let mut control =
        surefoot(&["control", file, "--instance", name, "--rate", rate]).spawn().unwrap();
    let mut plan = surefoot(&["plan", file, "--quiet", "--instance", name]).spawn().unwrap();
    while control.try_wait().unwrap().is_none() || plan.try_wait().unwrap().is_none() {
        meanwhile();
        std::thread::sleep(Duration::from_micros(200));
    }
    [finish(control), finish(plan)]
}

#[test]
fn an_observer_receives_every_tick_of_a_walk() {
    let name = format!("test-state-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let observer = Observer::open(&instance).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut states = vec![];
    let output = walk_by_hand(&name, &short_walk(folder.path()), "10", || {
        while let Some(state) = observer.state().unwrap() {
            states.push(state);
        }
    });
    assert!(output.iter().all(|output| output.code == 0), "{}{}", output[0].err, output[1].err);
    let end = states.last().unwrap().waypoint.time;
    assert!(end > 3.0, "{end}");
    for pair in states.windows(2) {
        // On a loaded machine a chunk may come late, and the robot stands for some ticks.
        let passed = pair[1].waypoint.time - pair[0].waypoint.time;
        assert!((-1e-9..TICK + 1e-9).contains(&passed), "{passed} at tick {}", pair[1].tick);
        assert_eq!(pair[1].tick, pair[0].tick + 1);
    }
    assert_eq!((states[0].tick, states[0].waypoint.time), (1, 0.0));
}

#[test]
fn an_observer_that_never_reads_does_not_block_the_walk() {
    let name = format!("test-idle-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let idle_observer = Observer::open(&instance).unwrap();
    // It reads until it receives the first tick, and never again.
    let mut first = None;
    let [control, plan] = walk_by_hand(&name, &scenario("ibeam_gap"), "0", || {
        first = first.or_else(|| idle_observer.state().unwrap())
    });
    assert_eq!((control.code, plan.code), (0, 0), "{}{}", control.err, plan.err);
    assert!(plan.out.contains("walked and accepted"), "{}", plan.out);
    assert!(first.is_some());
}
