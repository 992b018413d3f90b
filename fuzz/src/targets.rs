//! Every reader of outside data, each as a function of bytes.
//!
//! A reader may refuse its input. It must not panic, hang or allocate much more than its input, and
//! its error is printable text, one line for each complaint.

use std::cell::RefCell;
use std::fs;
use std::path::Path;

use bytemuck::{Pod, Zeroable, bytes_of_mut};
use surefoot_controller_sim::{Checker, ChunkExecutor, Identity, check_plan};
use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::{
    Feedback, JournalRecord, PlanChunk, PlanRequest, PlanStatus, SimulationState, WithCrc,
};
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;

/// A reader of one kind of data.
#[derive(Clone, Copy)]
pub struct Target {
    /// Its name, and that of its corpus.
    pub name: &'static str,
    /// Reads bytes. The folder is for files, and belongs to the caller's thread.
    pub run: fn(&[u8], &Path),
}

/// All readers.
pub const TARGETS: [Target; 14] = [
    Target { name: "stl", run: |bytes, folder| mesh(bytes, folder, "stl") },
    Target { name: "obj", run: |bytes, folder| mesh(bytes, folder, "obj") },
    Target { name: "collada", run: |bytes, folder| mesh(bytes, folder, "dae") },
    Target { name: "urdf", run: urdf },
    Target { name: "robot", run: robot },
    Target { name: "world", run: world },
    Target { name: "scenario", run: scenario },
    Target { name: "plan", run: plan },
    Target { name: "chunk", run: |bytes, _| chunk(bytes) },
    Target { name: "feedback", run: |bytes, _| feedback(bytes) },
    Target { name: "request", run: |bytes, _| request(bytes) },
    Target { name: "state", run: |bytes, _| state(bytes) },
    Target { name: "journal", run: |bytes, _| journal(bytes) },
    Target { name: "preparation", run: |bytes, _| preparation(bytes) },
];

const ROBOT: &str = include_str!("../../configs/robots/hubo/robot.toml");
const URDF: &str = include_str!("../../configs/robots/hubo/hubo.urdf");
const FLOOR: &str = include_str!("../../configs/worlds/flat_walk.toml");
const SCENARIO: &str = include_str!("../../configs/scenarios/flat_walk.toml");

/// The target of a name.
pub fn named(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|target| target.name == name)
}

/// A mesh as part of a world, once as a surface and once as a hull.
fn mesh(bytes: &[u8], folder: &Path, ending: &str) {
    write(folder, &format!("mesh.{ending}"), bytes);
    let world = format!(
        "mu = 0.6\n[[shapes]]\nname = \"a\"\nxyz = [0.0, 0.0, 0.0]\nmesh = {{ path = \
         \"mesh.{ending}\" }}\n"
    );
    write(folder, "world.toml", world.as_bytes());
    expect_clear(load_world(&folder.join("world.toml")));
}

fn urdf(bytes: &[u8], folder: &Path) {
    write(folder, "hubo.urdf", bytes);
    write(folder, "robot.toml", ROBOT.as_bytes());
    expect_clear(load_robot(&folder.join("robot.toml")));
}

fn robot(bytes: &[u8], folder: &Path) {
    write(folder, "hubo.urdf", URDF.as_bytes());
    write(folder, "robot.toml", bytes);
    expect_clear(load_robot(&folder.join("robot.toml")));
}

fn world(bytes: &[u8], folder: &Path) {
    write(folder, "world.toml", bytes);
    expect_clear(load_world(&folder.join("world.toml")));
}

fn scenario(bytes: &[u8], folder: &Path) {
    write(folder, "scenario.toml", bytes);
    expect_clear(load_scenario(&folder.join("scenario.toml")));
}

/// A plan, and the checks of `surefoot check` where it can be read.
fn plan(bytes: &[u8], folder: &Path) {
    write(folder, "plan.json", bytes);
    let path = folder.join("plan.json");
    if let Some(plan) = expect_clear(load_plan(&path)) {
        expect_clear(check_plan(&plan, &path));
    }
}

/// A chunk, as it is and with the identity and CRC that a controller expects.
fn chunk(bytes: &[u8]) {
    type Known = RefCell<Option<(ChunkExecutor, Identity)>>;
    thread_local!(static EXECUTOR: Known = const { RefCell::new(None) });
    let mut chunk: PlanChunk = message(bytes);
    EXECUTOR.with_borrow_mut(|known| {
        let (executor, identity) = known.get_or_insert_with(executor);
        assert!(executor.check_and_execute(&chunk).is_err());
        (chunk.schema, chunk.target_controller, chunk.sequence) = (1, identity.controller_id, 0);
        (chunk.robot, chunk.world, chunk.config) =
            (identity.robot, identity.world, identity.config);
        chunk.write_crc();
        if executor.check_and_execute(&chunk).is_ok() {
            *known = None;
        }
    });
}

fn feedback(bytes: &[u8]) {
    let mut feedback: Feedback = message(bytes);
    let _ = feedback.is_well_formed();
    feedback.write_crc();
    if feedback.is_well_formed() {
        let _ = (feedback.corrections().len(), feedback.rest_state.is_well_formed());
    }
}

fn request(bytes: &[u8]) {
    let mut request: PlanRequest = message(bytes);
    request.write_crc();
    let _ =
        (request.known_kind(), request.start.requested_pose(0.2), request.goal.requested_pose(0.2));
    let mut status: PlanStatus = message(bytes);
    status.write_crc();
    let _ = status.known_state();
}

fn state(bytes: &[u8]) {
    let _ = message::<SimulationState>(bytes).is_well_formed();
}

fn journal(bytes: &[u8]) {
    let mut record: JournalRecord = message(bytes);
    let _ = record.is_well_formed();
    record.feedback.write_crc();
    record.write_crc();
    let _ = record.is_well_formed();
}

/// A preparation from the cache, as it is and with the digest that its header promises.
fn preparation(bytes: &[u8]) {
    /// The place of the key in the header, after magic, version and padding.
    const KEY_AT: usize = 16;
    const DIGEST_AT: usize = KEY_AT + size_of::<Digest>();
    const REST_AT: usize = DIGEST_AT + size_of::<Digest>();
    let mut bytes = bytes.to_vec();
    bytes.resize(bytes.len().max(REST_AT).next_multiple_of(8), 0);
    let key: Digest = bytemuck::pod_read_unaligned(&bytes[KEY_AT..DIGEST_AT]);
    let _ = Preparation::from_bytes(&bytes, &key);
    let digest = Digest::of(&[&bytes[REST_AT..]]);
    bytes[DIGEST_AT..REST_AT].copy_from_slice(&digest.0);
    let _ = Preparation::from_bytes(&bytes, &key);
}

/// A message of the bytes, cut or filled with zeros.
fn message<M: Pod + Zeroable>(bytes: &[u8]) -> M {
    let mut message = M::zeroed();
    let space = bytes_of_mut(&mut message);
    let len = bytes.len().min(space.len());
    space[..len].copy_from_slice(&bytes[..len]);
    message
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    fs::write(folder.join(name), bytes).expect("the folder can be written");
}

/// The value. An error must be lines of printable text, one for each complaint.
fn expect_clear<T, E: std::fmt::Display>(read: Result<T, E>) -> Option<T> {
    let text = match read {
        Ok(value) => return Some(value),
        Err(error) => error.to_string(),
    };
    let is_clear = |line: &str| !line.is_empty() && !line.chars().any(char::is_control);
    assert!(!text.is_empty() && text.split('\n').all(is_clear), "{text:?}");
    None
}

fn executor() -> (ChunkExecutor, Identity) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    write(folder.path(), "hubo.urdf", URDF.as_bytes());
    write(folder.path(), "robot.toml", ROBOT.as_bytes());
    write(folder.path(), "world.toml", FLOOR.as_bytes());
    write(folder.path(), "scenario.toml", SCENARIO.as_bytes());
    let scenario = load_scenario(&path("scenario.toml")).expect("a shipped scenario");
    let model = load_robot(&path("robot.toml")).expect("a shipped robot");
    let world = load_world(&path("world.toml")).expect("a shipped world");
    let identity = Identity {
        controller_id: 3,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let checker = Checker::new(model, world, scenario.checker).expect("a shipped scenario");
    (ChunkExecutor::new(checker, identity), identity)
}
