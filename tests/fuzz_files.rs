//! Every reader of outside data on changed inputs: no panic, no hang, no large allocation, and
//! errors of printable text. The readers are the targets of `fuzz/`.
//!
//! `SUREFOOT_FUZZ=100000 cargo test --release --test fuzz_files -- --nocapture` reads as many
//! inputs with each target.

#![allow(clippy::unwrap_used, reason = "a seed that cannot be read fails the test")]

#[path = "common/change.rs"]
mod change;
#[path = "common/peak_allocator.rs"]
mod peak_allocator;
#[path = "../planner/tests/common/preparation.rs"]
mod preparation;
#[path = "common/private_folder.rs"]
mod private_folder;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/random.rs"]
mod random;
#[path = "../fuzz/src/targets.rs"]
mod targets;

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use bytemuck::{Zeroable, bytes_of};
use change::changed;
use peak_allocator::peak_of;
use preparation::preparation_for;
use private_folder::private_folder;
use random::Random;
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{
    Feedback, JournalRecord, Layout, PlanRequest, PlanStatus, SimulationState,
};
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::plan_file::write::plan_from_chunks;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use targets::{TARGETS, Target};

/// Inputs of each target by default; of some that are slow, fewer.
const INPUTS: u64 = 2_000;
const FEWER_INPUTS: [(&str, u64); 4] =
    [("urdf", 400), ("robot", 400), ("plan", 60), ("preparation", 60)];
/// Bytes that a reader may hold beside a multiple of its input.
const HELD_BYTES_MAX: usize = 64 << 20;
/// Bytes that a reader may hold for each byte of its input.
const HELD_PER_BYTE_MAX: usize = 200;
/// Time after which a reader counts as hanging, also on a loaded machine.
const HANG_SECONDS: u64 = 120;

fn inputs(target: &Target) -> u64 {
    let fewer = FEWER_INPUTS.iter().find(|(name, _)| *name == target.name);
    let default = fewer.map_or(INPUTS, |(_, inputs)| *inputs);
    std::env::var("SUREFOOT_FUZZ").ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Valid inputs of the targets that read no file of the repository.
struct Made {
    plan: Vec<u8>,
    chunk: Vec<u8>,
    preparation: Vec<u8>,
}

impl Made {
    /// Plans a walk of one step.
    fn new() -> Self {
        let mut scenario = load_scenario("configs/scenarios/flat_walk.toml".as_ref()).unwrap();
        scenario.goal.position = scenario.start.position;
        scenario.goal.position.x += 0.2;
        let model = load_robot(&scenario.robot_path).unwrap();
        let world = load_world(&scenario.world_path).unwrap();
        let prepared = preparation_for(&model, &scenario.planner);
        let preparation = prepared.bytes().to_vec();
        let mut planner = Planner::builder(&model, &world, &scenario, prepared).build().unwrap();
        assert_eq!(planner.step(u64::MAX), Status::Done(Outcome::Found));
        let chunks = planner.chunks();
        let plan = plan_from_chunks(&model, &world, &scenario, chunks, Path::new("."));
        let plan = serde_json::to_vec(&plan).unwrap();
        Self { plan, chunk: bytes_of(&chunks[0]).to_vec(), preparation }
    }
}

/// Valid inputs of a target.
fn seeds(target: &Target, made: &Made) -> Vec<Vec<u8>> {
    let files = |paths: &[&str]| paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
    match target.name {
        "urdf" => files(&["configs/robots/hubo/hubo.urdf"]),
        "robot" => files(&["configs/robots/hubo/robot.toml"]),
        "world" => files(&["configs/worlds/beam.toml", "configs/worlds/flat_walk.toml"]),
        "scenario" => files(&["configs/scenarios/flat_walk.toml"]),
        "plan" => vec![made.plan.clone()],
        "chunk" => vec![made.chunk.clone()],
        "preparation" => vec![made.preparation.clone()],
        "feedback" => vec![bytes_of(&feedback()).to_vec()],
        "journal" => vec![bytes_of(&journal_record()).to_vec()],
        "request" => vec![
            bytes_of(&PlanRequest {
                schema: 1,
                kind: 2,
                client: 1,
                number: 1,
                ..Zeroable::zeroed()
            })
            .to_vec(),
            bytes_of(&PlanStatus { schema: 1, session: 1, ..Zeroable::zeroed() }).to_vec(),
        ],
        "state" => {
            let state = SimulationState { schema: 1, controller_id: 1, ..Zeroable::zeroed() };
            vec![bytes_of(&state).to_vec()]
        }
        name => {
            let folder = std::fs::read_dir(Path::new("fuzz/corpus").join(name)).unwrap();
            let mut paths: Vec<_> = folder.map(|entry| entry.unwrap().path()).collect();
            paths.sort();
            paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
        }
    }
}

fn feedback() -> Feedback {
    Feedback {
        schema: FEEDBACK_SCHEMA,
        controller_id: 7,
        session: 5,
        plan_id: 1,
        count: 3,
        next_sequence: 1,
        verdict: 1,
        finished: 1,
        ..Zeroable::zeroed()
    }
}

fn journal_record() -> JournalRecord {
    JournalRecord {
        layout: JournalRecord::HASH,
        generation: 1,
        feedback: feedback(),
        ..Zeroable::zeroed()
    }
}

/// Reads changed inputs. A failure names the file of its input.
fn read_inputs(target: &Target, seeds: &[Vec<u8>], begun: &AtomicU64) {
    let folder = private_folder("sf-fuzz");
    let seed = target.name.bytes().fold(7, |sum, byte| sum * 31 + u64::from(byte));
    for number in 0..inputs(target) {
        let bytes = changed(seeds, &mut Random(seed << 32 | number));
        begun.fetch_add(1, Ordering::Relaxed);
        let read = AssertUnwindSafe(|| (target.run)(&bytes, folder.path()));
        let (held, outcome) = peak_of(|| catch_unwind(read));
        let held_max = HELD_BYTES_MAX + HELD_PER_BYTE_MAX * bytes.len();
        if outcome.is_err() || held > held_max {
            let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{number}-input"));
            std::fs::write(&file, &bytes).unwrap();
            panic!("{} with {}: {held} bytes held, {outcome:?}", target.name, file.display());
        }
    }
}

/// Ends the process where an input takes too long: a thread cannot be ended.
fn watch(begun: &AtomicU64, is_over: &AtomicBool, name: &str) {
    let (mut known, mut seconds) = (0, 0);
    while !is_over.load(Ordering::Relaxed) {
        std::thread::park_timeout(Duration::from_secs(1));
        let now = begun.load(Ordering::Relaxed);
        seconds = if now == known { seconds + 1 } else { 0 };
        known = now;
        if seconds > HANG_SECONDS {
            let text = format!("{name} hangs at its input {}\n", now - 1);
            let _ = std::io::stderr().write_all(text.as_bytes());
            std::process::exit(101);
        }
    }
}

#[test]
fn every_reader_survives_changed_inputs() {
    let made = Made::new();
    for target in &TARGETS {
        let seeds = seeds(target, &made);
        let (begun, is_over) = (AtomicU64::new(0), AtomicBool::new(false));
        std::thread::scope(|scope| {
            let watching = scope.spawn(|| watch(&begun, &is_over, target.name));
            let outcome = catch_unwind(AssertUnwindSafe(|| read_inputs(target, &seeds, &begun)));
            is_over.store(true, Ordering::Relaxed);
            watching.thread().unpark();
            if let Err(panic) = outcome {
                std::panic::resume_unwind(panic);
            }
        });
    }
}

#[test]
fn every_target_reads_its_own_seeds() {
    let made = Made::new();
    let folder = private_folder("sf-fuzz");
    for target in &TARGETS {
        let seeds = seeds(target, &made);
        assert!(!seeds.is_empty(), "{}", target.name);
        for seed in &seeds {
            (target.run)(seed, folder.path());
        }
    }
    let read = |name: &str| {
        let target = targets::named(name).unwrap();
        seeds(&target, &made).iter().for_each(|seed| (target.run)(seed, folder.path()));
    };
    for mesh in ["stl", "obj", "collada"] {
        read(mesh);
        let world = load_world(&folder.path().join("world.toml"));
        assert!(world.is_ok(), "{mesh}: {world:?}");
    }
    assert!(load_plan(&folder.path().join("plan.json")).is_ok());
}

#[test]
fn every_target_has_a_fuzzer() {
    let manifest = std::fs::read_to_string("fuzz/Cargo.toml").unwrap();
    for Target { name, .. } in &TARGETS {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name}");
        let fuzzer = std::fs::read_to_string(format!("fuzz/fuzz_targets/{name}.rs")).unwrap();
        assert!(fuzzer.contains(&format!("\"{name}\"")), "{name}");
    }
}
