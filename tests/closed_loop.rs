//! A walk in a world that differs from the planner's: the robot holds its position, reports the
//! difference, and continues with a plan from where it stands.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped scenario cannot be used")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use bytemuck::Zeroable;
use glam::DVec3;
use preparation::preparation_for;
use surefoot_controller_sim::{Checker, ChunkExecutor, Identity};
use surefoot_planner::pipeline::Retrace;
use surefoot_planner::pipeline::outcome::EndpointError;
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{
    Check, Contact, Feedback, PlanChunk, RestState, SupportMode, WithCrc, WorldCorrection,
};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::{World, WorldShape};

const CONTROLLER_ID: u64 = 3;

struct Case {
    scenario: Scenario,
    model: RobotModel,
    world: World,
}

impl Case {
    fn load(name: &str) -> Self {
        let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
        let scenario = scenario.with_motion(MotionKind::QuasiStatic);
        let (model, world) =
            (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
        Self { scenario, model, world }
    }

    fn executor(&self) -> ChunkExecutor {
        let identity = Identity {
            controller_id: CONTROLLER_ID,
            robot: self.model.digest,
            world: self.world.digest,
            config: self.scenario.digest,
        };
        ChunkExecutor::new(
            Checker::new(self.model.clone(), self.world.clone(), self.scenario.checker.clone())
                .unwrap(),
            identity,
        )
    }

    /// A plan in a world, from the scenario's start or from where the robot stands.
    fn plan(
        &self,
        world: &World,
        missing: Option<&WorldCorrection>,
        rest_state: Option<&RestState>,
        epoch: u64,
    ) -> Result<Vec<PlanChunk>, Outcome> {
        let start = rest_state.and_then(RestState::stance_pose).unwrap_or(self.scenario.start);
        let scenario = Scenario { start, ..self.scenario.clone() };
        let preparation = preparation_for(&self.model, &scenario.planner);
        let mut builder =
            Planner::builder(&self.model, world, &scenario, preparation).plan_name(1, epoch);
        if let Some(rest_state) = rest_state {
            builder = builder.start_in(rest_state);
        }
        if let Some(missing) = missing {
            let [half_length, half_width, _] = missing.half_extents;
            builder = builder.keep_out(missing.pose(), [half_length, half_width]);
        }
        let mut planner = builder.build().unwrap();
        loop {
            match planner.step(1_000_000) {
                Status::Working => {}
                Status::Done(Outcome::Found) => return Ok(planner.chunks().to_vec()),
                Status::Done(outcome) => return Err(outcome),
            }
        }
    }
}

fn addressed(chunk: &PlanChunk) -> PlanChunk {
    let mut chunk = PlanChunk { target_controller: CONTROLLER_ID, session: 1, ..*chunk };
    chunk.write_crc();
    chunk
}

/// Walks chunks; where the robot stands then.
fn walk(executor: &mut ChunkExecutor, chunks: &[PlanChunk], rest_state: RestState) -> RestState {
    chunks.iter().fold(rest_state, |rest_state, chunk| {
        executor
            .check_and_execute(&addressed(chunk))
            .unwrap_or_else(|violation| panic!("chunk {}: {violation:?}", chunk.sequence));
        rest_state.after(chunk.mode, chunk.contacts(), chunk.waypoints().last().unwrap())
    })
}

/// The chunks of a plan before which the robot stands on one foot and the other is about to land.
fn landings(chunks: &[PlanChunk]) -> Vec<usize> {
    let is_double = |chunk: &PlanChunk| chunk.mode == SupportMode::Double as u32;
    (1..chunks.len())
        .filter(|&index| is_double(&chunks[index]) && !is_double(&chunks[index - 1]))
        .collect()
}

/// Replans at a landing whose ground turns out to be missing; answers the rest of the way.
fn replan_at_landing(case: &Case, landing: usize) -> (Vec<PlanChunk>, WorldCorrection) {
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let at = landings(&chunks)[landing];
    let mut executor = case.executor();
    let rest_state = walk(&mut executor, &chunks[..at], RestState::zeroed());
    let lifted = if rest_state.mode == SupportMode::Left as u32 { 1 } else { 0 };
    let landed = chunks[at].contacts().iter().find(|contact| contact.limb == lifted).unwrap();
    let correction = WorldCorrection::contact_missing(&landed.world_from_sole(), [0.1, 0.05]);
    executor.correct(&correction);
    let stale = executor.check_and_execute(&addressed(&chunks[at])).unwrap_err();
    assert_eq!(stale.check, Check::World, "a plan for the uncorrected world is refused");
    let corrected = case.world.corrected(&[correction]).unwrap();
    let rest = case.plan(&corrected, Some(&correction), Some(&rest_state), 1).unwrap();
    assert!(
        (1..rest.len()).all(|index| rest[index].epoch == 1)
            && rest[0].mode != SupportMode::Double as u32
    );
    walk(&mut executor, &rest, rest_state);
    assert!(executor.finished());
    (rest, correction)
}

#[test]
fn the_robot_continues_from_one_foot_and_keeps_out_of_the_missing_contact() {
    for (name, landing) in [("flat_walk", 2), ("flat_walk", 5), ("stepping_stones", 3)] {
        let (rest, correction) = replan_at_landing(&Case::load(name), landing);
        let from_world = correction.pose().inverse();
        for contact in rest.iter().flat_map(PlanChunk::contacts) {
            let place = from_world * contact.world_from_sole().translation;
            let over = place.x.abs() < 0.09 && place.y.abs() < 0.045 && place.z.abs() < 0.02;
            assert!(!over, "{name}: a sole stands where nothing carried it");
        }
    }
}

#[test]
fn the_robot_continues_from_both_feet() {
    let case = Case::load("flat_walk");
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let both = (0..chunks.len())
        .filter(|&index| chunks[index].mode == SupportMode::Double as u32)
        .nth(3)
        .unwrap();
    let mut executor = case.executor();
    let rest_state = walk(&mut executor, &chunks[..=both], RestState::zeroed());
    let rest = case.plan(&case.world, None, Some(&rest_state), 1).unwrap();
    walk(&mut executor, &rest, rest_state);
    assert!(executor.finished());
}

#[test]
fn replanning_is_reproducible() {
    let case = Case::load("stepping_stones");
    let digest = |chunks: &[PlanChunk]| chunks.last().unwrap().stream_after();
    let [first, second] = [0, 1].map(|_| replan_at_landing(&case, 2).0);
    assert_eq!(digest(&first), digest(&second));
}

/// The low and the high end, along the world's y, of what carries a sole.
fn across(contact: &Contact) -> [f64; 2] {
    let corners = contact.polygon[..contact.polygon_len as usize].iter();
    let ys = corners.map(|[x, y]| (contact.world_from_sole() * DVec3::new(*x, *y, 0.0)).y);
    ys.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
}

/// Walks on the stones until the robot stands on both feet, one of them on a stone: where it
/// stands, that foot, and the stone.
fn rest_state_on_a_stone(case: &Case) -> (RestState, Contact, usize) {
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let stone_under = |contact: &Contact| {
        let carries = |shape: &WorldShape| {
            let at = shape.world_from_shape.inverse() * contact.world_from_sole().translation;
            shape.name.starts_with("stone") && at.x.abs() < 0.1 && at.y.abs() < 0.06
        };
        case.world.shapes.iter().position(carries)
    };
    let is_double = |chunk: &&PlanChunk| chunk.mode == SupportMode::Double as u32;
    let stands = |chunk: &PlanChunk| {
        chunk.contacts().iter().find_map(|contact| Some((*contact, stone_under(contact)?)))
    };
    let (at, (contact, stone)) = chunks
        .iter()
        .filter(is_double)
        .find_map(|chunk| Some((chunk.sequence, stands(chunk)?)))
        .unwrap();
    (walk(&mut case.executor(), &chunks[..=at as usize], RestState::zeroed()), contact, stone)
}

/// A correction that moves the stone aside so far that `uncovered` (m) of the sole's low side is
/// unsupported, and the stone's new edge.
fn moved_aside(
    case: &Case,
    stone: usize,
    contact: &Contact,
    uncovered: f64,
) -> (WorldCorrection, f64) {
    let mut pose = case.world.shapes[stone].world_from_shape;
    let edge = across(contact)[0] + uncovered;
    pose.translation.y = edge + 0.1;
    (WorldCorrection::moved(stone as u32, &pose), edge)
}

/// A controller that knows the corrected world, with the robot as it stands.
fn successor(
    case: &Case,
    corrected: World,
    correction: WorldCorrection,
    rest_state: &RestState,
) -> ChunkExecutor {
    let identity = Identity {
        controller_id: CONTROLLER_ID,
        robot: case.model.digest,
        world: case.world.digest,
        config: case.scenario.digest,
    };
    let mut feedback = Feedback {
        session: 1,
        plan_id: 1,
        corrections_len: 1,
        rest_state: *rest_state,
        ..Feedback::zeroed()
    };
    feedback.corrections[0] = correction;
    ChunkExecutor::take_over(
        Checker::new(case.model.clone(), corrected, case.scenario.checker.clone()).unwrap(),
        identity,
        &feedback,
    )
}

#[test]
fn a_stance_foot_keeps_only_its_support_in_the_corrected_world() {
    let case = Case::load("stepping_stones");
    let (rest_state, sole, stone) = rest_state_on_a_stone(&case);
    let (correction, edge) = moved_aside(&case, stone, &sole, 0.03);
    let corrected = case.world.corrected(&[correction]).unwrap();
    let rest = case.plan(&corrected, None, Some(&rest_state), 1).unwrap();
    let kept: Vec<_> = rest
        .iter()
        .flat_map(PlanChunk::contacts)
        .filter(|contact| contact.position == sole.position)
        .map(across)
        .collect();
    assert!(!kept.is_empty() && kept.iter().all(|[low, _]| *low > edge - 1e-6), "{edge}: {kept:?}");
    walk(&mut successor(&case, corrected, correction, &rest_state), &rest, rest_state);
}

#[test]
fn an_unsupported_stance_foot_ends_the_walk_with_an_invalid_start() {
    let case = Case::load("stepping_stones");
    let (rest_state, sole, stone) = rest_state_on_a_stone(&case);
    let (correction, _) = moved_aside(&case, stone, &sole, 0.3);
    let corrected = case.world.corrected(&[correction]).unwrap();
    let Err(Outcome::StartInvalid(EndpointError::Unsupported { limb, .. })) =
        case.plan(&corrected, None, Some(&rest_state), 1)
    else {
        panic!("a plan from where nothing carries")
    };
    assert_eq!(limb, sole.limb as usize);
}

/// A plan from where the robot stands once it has retraced so many stances.
fn plan_from_back(
    case: &Case,
    rest_state: &RestState,
    walked: &[PlanChunk],
    depth: usize,
) -> (Vec<PlanChunk>, Retrace) {
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    let mut planner = Planner::builder(&case.model, &case.world, &case.scenario, preparation)
        .plan_name(1, 1)
        .start_in(rest_state)
        .retrace(walked, depth)
        .build()
        .unwrap();
    assert_eq!(planner.step(1_000_000), Status::Done(Outcome::Found));
    (planner.chunks().to_vec(), planner.retrace())
}

#[test]
fn the_robot_retraces_its_steps() {
    let case = Case::load("flat_walk");
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let at = landings(&chunks)[3];
    let mut executor = case.executor();
    let rest_state = walk(&mut executor, &chunks[..at], RestState::zeroed());
    let (rest, retrace) = plan_from_back(&case, &rest_state, &chunks[..at], 2);
    assert_eq!(retrace.depth, 2);
    for (back, walked) in rest[..retrace.chunks].iter().zip(chunks[..at].iter().rev()) {
        let configurations = |chunk: &PlanChunk| {
            chunk.waypoints().iter().map(|at| (at.root_position, at.q)).collect::<Vec<_>>()
        };
        let mut backwards = configurations(walked);
        backwards.reverse();
        assert_eq!(
            (configurations(back), back.mode, back.contacts()),
            (backwards, walked.mode, walked.contacts())
        );
    }
    let lift_offs = rest[..retrace.chunks]
        .windows(2)
        .filter(|pair| pair[0].mode != pair[1].mode && pair[1].mode == SupportMode::Double as u32);
    assert_eq!(lift_offs.count(), 1, "one foot is set down on the way, the other one at its end");
    walk(&mut executor, &rest, rest_state);
    assert!(executor.finished());
}

#[test]
fn retracing_ends_with_the_recorded_chunks() {
    let case = Case::load("flat_walk");
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let at = landings(&chunks)[3];
    let rest_state = walk(&mut case.executor(), &chunks[..at], RestState::zeroed());
    let places =
        |walked: &[PlanChunk], places| plan_from_back(&case, &rest_state, walked, places).1.depth;
    assert_eq!(places(&chunks[..at], 100), 4, "as many as it has lifted a foot");
    assert_eq!(
        (places(&chunks[..at - 1], 1), places(&[], 1)),
        (0, 0),
        "what does not end where the robot stands leads nowhere"
    );
    let gap = [&chunks[..at - 12], &chunks[at - 11..at]].concat();
    assert!(places(&gap, 100) < 4, "past a gap nothing is known");
}
