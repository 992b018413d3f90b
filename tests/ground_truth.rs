//! The actual world differs from the planner's: the robot never steps on a refused foothold,
//! reports the difference, and a new plan continues from where it stands.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped scenario cannot be used")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use bytemuck::Zeroable;
use glam::DVec3;
use preparation::preparation_for;
use surefoot_controller_sim::{Checker, ChunkExecutor, GroundTruth, Identity};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{
    CorrectionKind, PlanChunk, RestState, WithCrc, WorldCorrection,
};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

const CONTROLLER_ID: u64 = 3;
/// Most plans of one walk.
const EPOCHS_MAX: u64 = 10;

/// A scenario and the actual world of the robot.
struct Case {
    scenario: Scenario,
    model: RobotModel,
    planner_world: World,
    actual: World,
}

/// How a walk ended.
struct WalkResult {
    arrived: bool,
    corrections: Vec<WorldCorrection>,
}

impl Case {
    fn new(name: &str, change: impl FnOnce(&mut World)) -> Self {
        let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
        let (model, planner_world) =
            (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
        let mut actual = planner_world.clone();
        change(&mut actual);
        Self { scenario, model, planner_world, actual }
    }

    fn executor(&self) -> ChunkExecutor {
        let identity = Identity {
            controller_id: CONTROLLER_ID,
            robot: self.model.digest,
            world: self.planner_world.digest,
            config: self.scenario.digest,
        };
        ChunkExecutor::new(
            Checker::new(self.model.clone(), self.actual.clone(), self.scenario.checker.clone())
                .unwrap(),
            identity,
        )
    }

    fn plan(
        &self,
        corrections: &[WorldCorrection],
        rest_state: &RestState,
        epoch: u64,
    ) -> Option<Vec<PlanChunk>> {
        let world = self.planner_world.corrected(corrections).unwrap();
        let start = rest_state.stance_pose().unwrap_or(self.scenario.start);
        let scenario = Scenario { start, ..self.scenario.clone() };
        let preparation = preparation_for(&self.model, &scenario.planner);
        let mut builder =
            Planner::builder(&self.model, &world, &scenario, preparation).plan_name(1, epoch);
        if rest_state.is_known() {
            builder = builder.start_in(rest_state);
        }
        let mut planner = builder.build().unwrap();
        match planner.step(u64::MAX) {
            Status::Done(Outcome::Found) => Some(planner.chunks().to_vec()),
            _ => None,
        }
    }

    /// Plans, executes, and plans again wherever the actual world differs.
    fn walk(&self) -> WalkResult {
        let mut executor = self.executor();
        let mut ground_truth =
            GroundTruth::new(&self.model, &self.planner_world, &self.actual).unwrap();
        let (mut corrections, mut rest_state) = (vec![], RestState::zeroed());
        for epoch in 0..EPOCHS_MAX {
            let Some(chunks) = self.plan(&corrections, &rest_state, epoch) else { break };
            for chunk in &chunks {
                let chunk = addressed(chunk);
                let before = executor.rest_state().cloned();
                let Err(violation) = executor.check_and_execute(&chunk) else {
                    let rest = &executor.rest_state().unwrap().waypoint;
                    rest_state = rest_state.after(chunk.mode, chunk.contacts(), rest);
                    continue;
                };
                assert_eq!(executor.rest_state(), before.as_ref(), "a refused chunk moves nothing");
                let correction = ground_truth
                    .encountered(&executor, &chunk, &violation)
                    .unwrap_or_else(|| panic!("not by the world: {violation}"));
                executor.correct(&correction);
                corrections.push(correction);
                break;
            }
            if executor.finished() {
                break;
            }
        }
        WalkResult { arrived: executor.finished(), corrections }
    }
}

fn addressed(chunk: &PlanChunk) -> PlanChunk {
    let mut chunk = PlanChunk { target_controller: CONTROLLER_ID, session: 1, ..*chunk };
    chunk.write_crc();
    chunk
}

fn shape<'a>(world: &'a mut World, name: &str) -> &'a mut WorldShape {
    world.shapes.iter_mut().find(|shape| shape.name == name).unwrap()
}

fn shift(world: &mut World, name: &str, by: [f64; 3]) {
    shape(world, name).world_from_shape.translation += DVec3::from(by);
}

/// The box of this kind that carries the largest part of a sole in the planner's world.
fn most_used(case: &Case, kind: &str) -> String {
    let chunks = case.plan(&[], &RestState::zeroed(), 0).unwrap();
    let soles = chunks
        .iter()
        .flat_map(PlanChunk::contacts)
        .map(|contact| (contact.world_from_sole(), contact.limb as usize));
    let corners: Vec<Vec<DVec3>> = soles
        .map(|(pose, limb)| {
            case.model.feet[limb].polygon.iter().map(|corner| pose * corner.extend(0.0)).collect()
        })
        .collect();
    let inside = |stone: &WorldShape, corner: &DVec3| match &stone.shape {
        Shape::Box { half_extents } => {
            let at = stone.world_from_shape.inverse() * *corner;
            at.x.abs() <= half_extents.x
                && at.y.abs() <= half_extents.y
                && (at.z - half_extents.z).abs() < 1e-3
        }
        _ => false,
    };
    let used = |stone: &&WorldShape| {
        corners
            .iter()
            .map(|sole| sole.iter().filter(|corner| inside(stone, corner)).count())
            .max()
            .unwrap()
    };
    case.planner_world
        .shapes
        .iter()
        .filter(|shape| shape.name.starts_with(kind))
        .max_by_key(used)
        .unwrap()
        .name
        .clone()
}

/// Walks to the goal and encounters exactly the one difference that there is.
fn arrives_after_meeting(case: &Case, kind: CorrectionKind) {
    let result = case.walk();
    let kinds: Vec<_> =
        result.corrections.iter().map(|correction| correction.known_kind().unwrap()).collect();
    assert!(result.arrived, "corrections {kinds:?}");
    assert_eq!(kinds, [kind]);
}

#[test]
fn a_stone_stands_lower() {
    let name = most_used(&Case::new("stepping_stones", |_| ()), "stone");
    arrives_after_meeting(
        &Case::new("stepping_stones", |world| shift(world, &name, [0.0, 0.0, -0.03])),
        CorrectionKind::Moved,
    );
}

#[test]
fn the_robot_arrives_with_any_stone_lowered() {
    let planner_world = Case::new("stepping_stones", |_| ()).planner_world;
    let stones = planner_world.shapes.iter().filter(|shape| shape.name.starts_with("stone"));
    let mut corrections = 0;
    for stone in stones.map(|stone| &stone.name) {
        let result =
            Case::new("stepping_stones", |world| shift(world, stone, [0.0, 0.0, -0.03])).walk();
        assert!(result.arrived, "{stone}");
        assert!(
            result
                .corrections
                .iter()
                .all(|correction| correction.known_kind() == Some(CorrectionKind::Moved)),
            "{stone}"
        );
        corrections += result.corrections.len();
    }
    assert!(corrections > 8, "hardly any stone is used");
}

#[test]
fn a_stone_stands_higher() {
    let name = most_used(&Case::new("stepping_stones", |_| ()), "stone");
    arrives_after_meeting(
        &Case::new("stepping_stones", |world| shift(world, &name, [0.0, 0.0, 0.03])),
        CorrectionKind::Moved,
    );
}

#[test]
fn a_stone_is_tilted() {
    let tilt = |world: &mut World| {
        let pose = &mut shape(world, "stone_left_4").world_from_shape;
        pose.rotation = rotation_about(DVec3::X, 0.15) * pose.rotation;
    };
    arrives_after_meeting(&Case::new("stepping_stones", tilt), CorrectionKind::Moved);
}

#[test]
fn a_stone_stands_aside() {
    let name = most_used(&Case::new("stepping_stones", |_| ()), "stone");
    let outward = if name.contains("left") { 0.16 } else { -0.16 };
    arrives_after_meeting(
        &Case::new("stepping_stones", |world| shift(world, &name, [0.0, outward, 0.0])),
        CorrectionKind::Moved,
    );
}

#[test]
fn a_stone_is_missing() {
    let name = most_used(&Case::new("stepping_stones", |_| ()), "stone");
    let remove = |world: &mut World| world.shapes.retain(|shape| shape.name != name);
    arrives_after_meeting(&Case::new("stepping_stones", remove), CorrectionKind::Missing);
}

#[test]
fn a_block_is_an_obstacle() {
    let extra = |world: &mut World| {
        let shape = Shape::Box { half_extents: DVec3::new(0.05, 0.3, 0.04) };
        let world_from_shape = Pose::from_translation(DVec3::new(1.1, 0.0, 0.04));
        world.shapes.push(WorldShape { name: "extra".into(), world_from_shape, shape });
    };
    arrives_after_meeting(&Case::new("ibeam_gap", extra), CorrectionKind::Extra);
}

#[test]
fn a_cinder_block_stands_lower() {
    let name = most_used(&Case::new("cinder_blocks", |_| ()), "block");
    arrives_after_meeting(
        &Case::new("cinder_blocks", |world| shift(world, &name, [0.0, 0.0, -0.03])),
        CorrectionKind::Moved,
    );
}

#[test]
fn a_cinder_block_is_tilted() {
    let name = most_used(&Case::new("cinder_blocks", |_| ()), "block");
    let tilt = |world: &mut World| {
        let pose = &mut shape(world, &name).world_from_shape;
        pose.rotation = rotation_about(DVec3::Y, 0.12) * pose.rotation;
    };
    arrives_after_meeting(&Case::new("cinder_blocks", tilt), CorrectionKind::Moved);
}

#[test]
fn a_cinder_block_is_missing() {
    let name = most_used(&Case::new("cinder_blocks", |_| ()), "block");
    let remove = |world: &mut World| world.shapes.retain(|shape| shape.name != name);
    let mut case = Case::new("cinder_blocks", remove);
    case.scenario = case.scenario.with_motion(MotionKind::QuasiStatic);
    arrives_after_meeting(&case, CorrectionKind::Missing);
}

#[test]
fn a_walk_without_a_route_ends_with_a_refusal() {
    let no_beams = |world: &mut World| world.shapes.retain(|shape| !shape.name.starts_with("beam"));
    let mut case = Case::new("ibeam_gap", no_beams);
    case.scenario.planner.work_max = 300_000;
    let result = case.walk();
    assert!(!result.arrived && !result.corrections.is_empty());
    assert!(
        result
            .corrections
            .iter()
            .all(|correction| correction.known_kind() == Some(CorrectionKind::Missing))
    );
}
