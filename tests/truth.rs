//! The world is not as the planner believes: the robot never steps on a refused foothold, says what
//! it met, and a new plan from where it stands goes on.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped scenario cannot be used")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::num::NonZeroUsize;

use bytemuck::Zeroable;
use glam::DVec3;
use preparation::preparation_for;
use surefoot_controller_sim::{Checker, Identity, Truth, Walker};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::Scenario;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::message::{Correction, CorrectionKind, PlanChunk, Sealed, Standing};
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scene::load::load_world;
use surefoot_shared_types::scene::{World, WorldShape};
use surefoot_shared_types::spatial::rotation_about;
use surefoot_shared_types::{Pose, Shape};

const INSTANCE: u64 = 3;
/// Most plans of one walk.
const EPOCHS_MAX: u64 = 10;

/// A scenario and the world in which the robot really walks it.
struct Case {
    scenario: Scenario,
    model: RobotModel,
    belief: World,
    truth: World,
}

/// How a walk ended.
struct Walked {
    arrived: bool,
    met: Vec<Correction>,
}

impl Case {
    fn new(name: &str, change: impl FnOnce(&mut World)) -> Self {
        let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
        let (model, belief) =
            (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
        let mut truth = belief.clone();
        change(&mut truth);
        Self { scenario, model, belief, truth }
    }

    fn walker(&self) -> Walker {
        let identity = Identity {
            instance: INSTANCE,
            robot: self.model.digest,
            world: self.belief.digest,
            config: self.scenario.digest,
        };
        Walker::new(
            Checker::new(self.model.clone(), self.truth.clone(), self.scenario.checker.clone())
                .unwrap(),
            identity,
        )
    }

    fn plan(&self, met: &[Correction], standing: &Standing, epoch: u64) -> Option<Vec<PlanChunk>> {
        let world = self.belief.corrected(met).unwrap();
        let start = standing.mark().unwrap_or(self.scenario.start);
        let scenario = Scenario { start, ..self.scenario.clone() };
        let mut planner = Planner::new(
            &self.model,
            &world,
            &scenario,
            preparation_for(&self.model, &scenario.planner),
            NonZeroUsize::MIN,
        )
        .unwrap();
        if standing.is_known() {
            planner.begin_at(&world, standing).unwrap();
        }
        planner.name_plan(1, epoch);
        match planner.step(u64::MAX) {
            Status::Done(Outcome::Found) => Some(planner.chunks().to_vec()),
            _ => None,
        }
    }

    /// Plans, walks, and plans again wherever the world turns out to be another.
    fn walk(&self) -> Walked {
        let mut walker = self.walker();
        let mut truth = Truth::new(&self.model, &self.belief, &self.truth).unwrap();
        let (mut met, mut standing) = (vec![], Standing::zeroed());
        for epoch in 0..EPOCHS_MAX {
            let Some(chunks) = self.plan(&met, &standing, epoch) else { break };
            for chunk in &chunks {
                let chunk = addressed(chunk);
                let before = walker.standing().cloned();
                let Err(violation) = walker.admit_and_walk(&chunk) else {
                    standing = standing.after(
                        chunk.mode,
                        chunk.contacts(),
                        chunk.waypoints().last().unwrap(),
                    );
                    continue;
                };
                assert_eq!(walker.standing(), before.as_ref(), "a refused chunk moves nothing");
                let correction = truth
                    .met(&walker, &chunk, &violation)
                    .unwrap_or_else(|| panic!("not by the world: {violation}"));
                walker.correct(&correction);
                met.push(correction);
                break;
            }
            if walker.finished() {
                break;
            }
        }
        Walked { arrived: walker.finished(), met }
    }
}

fn addressed(chunk: &PlanChunk) -> PlanChunk {
    let mut chunk = PlanChunk { target_instance: INSTANCE, session: 1, ..*chunk };
    chunk.seal();
    chunk
}

fn shape<'a>(world: &'a mut World, name: &str) -> &'a mut WorldShape {
    world.shapes.iter_mut().find(|shape| shape.name == name).unwrap()
}

fn shift(world: &mut World, name: &str, by: [f64; 3]) {
    shape(world, name).world_from_shape.translation += DVec3::from(by);
}

/// The box of this kind on which the planner, as it believes the world to be, stands with most of a
/// sole.
fn most_used(case: &Case, kind: &str) -> String {
    let chunks = case.plan(&[], &Standing::zeroed(), 0).unwrap();
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
    case.belief
        .shapes
        .iter()
        .filter(|shape| shape.name.starts_with(kind))
        .max_by_key(used)
        .unwrap()
        .name
        .clone()
}

/// Walks to the goal and meets exactly the one difference that there is.
fn arrives_after_meeting(case: &Case, kind: CorrectionKind) {
    let walked = case.walk();
    let kinds: Vec<_> =
        walked.met.iter().map(|correction| correction.known_kind().unwrap()).collect();
    assert!(walked.arrived, "met {kinds:?}");
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
fn whichever_stone_stands_lower_the_robot_arrives() {
    let belief = Case::new("stepping_stones", |_| ()).belief;
    let stones = belief.shapes.iter().filter(|shape| shape.name.starts_with("stone"));
    let mut met = 0;
    for stone in stones.map(|stone| &stone.name) {
        let walked =
            Case::new("stepping_stones", |world| shift(world, stone, [0.0, 0.0, -0.03])).walk();
        assert!(walked.arrived, "{stone}");
        assert!(
            walked
                .met
                .iter()
                .all(|correction| correction.known_kind() == Some(CorrectionKind::Moved)),
            "{stone}"
        );
        met += walked.met.len();
    }
    assert!(met > 8, "hardly any stone is used");
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
fn a_block_lies_in_the_way() {
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
    arrives_after_meeting(&Case::new("cinder_blocks", remove), CorrectionKind::Missing);
}

#[test]
fn where_no_way_remains_the_walk_ends_honestly() {
    let no_beams = |world: &mut World| world.shapes.retain(|shape| !shape.name.starts_with("beam"));
    let mut case = Case::new("ibeam_gap", no_beams);
    case.scenario.planner.work_max = 300_000;
    let walked = case.walk();
    assert!(!walked.arrived && !walked.met.is_empty());
    assert!(
        walked
            .met
            .iter()
            .all(|correction| correction.known_kind() == Some(CorrectionKind::Missing))
    );
}
