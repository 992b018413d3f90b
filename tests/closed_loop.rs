//! A walk that meets another world: the robot holds, says what it met, and goes on by a plan made from where it stands.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped scenario cannot be used")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::num::NonZeroUsize;

use bytemuck::Zeroable;
use preparation::preparation_for;
use surefoot_controller_sim::{Checker, Identity, Walker};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::Scenario;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::message::{Check, Correction, PlanChunk, Sealed, Standing, SupportMode};
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scene::World;
use surefoot_shared_types::scene::load::load_world;

const INSTANCE: u64 = 3;

struct Case {
    scenario: Scenario,
    model: RobotModel,
    world: World,
}

impl Case {
    fn load(name: &str) -> Self {
        let scenario = load_scenario(format!("configs/scenarios/{name}.toml").as_ref()).unwrap();
        let (model, world) = (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
        Self { scenario, model, world }
    }

    fn walker(&self) -> Walker {
        let identity = Identity { instance: INSTANCE, robot: self.model.digest, world: self.world.digest, config: self.scenario.digest };
        Walker::new(Checker::new(self.model.clone(), self.world.clone(), self.scenario.checker.clone()).unwrap(), identity)
    }

    /// A plan in a world, from the scenario's start or from where the robot stands.
    fn plan(
        &self,
        world: &World,
        missing: Option<&Correction>,
        standing: Option<&Standing>,
        epoch: u64,
    ) -> Result<Vec<PlanChunk>, Outcome> {
        let start = standing.and_then(Standing::mark).unwrap_or(self.scenario.start);
        let scenario = Scenario { start, ..self.scenario.clone() };
        let mut planner =
            Planner::new(&self.model, world, &scenario, preparation_for(&self.model, &scenario.planner), NonZeroUsize::MIN).unwrap();
        if let Some(standing) = standing {
            planner.begin_at(standing);
        }
        if let Some(missing) = missing {
            planner.shun(&missing.pose(), [missing.half_extents[0], missing.half_extents[1]]);
        }
        planner.name_plan(1, epoch);
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
    let mut chunk = PlanChunk { target_instance: INSTANCE, session: 1, ..*chunk };
    chunk.seal();
    chunk
}

/// Walks chunks; where the robot stands then.
fn walk(walker: &mut Walker, chunks: &[PlanChunk], standing: Standing) -> Standing {
    chunks.iter().fold(standing, |standing, chunk| {
        walker.admit_and_walk(&addressed(chunk)).unwrap_or_else(|violation| panic!("chunk {}: {violation:?}", chunk.sequence));
        standing.after(chunk.mode, chunk.contacts(), chunk.waypoints().last().unwrap())
    })
}

/// The chunks of a plan before which the robot stands on one foot and the other is about to land.
fn landings(chunks: &[PlanChunk]) -> Vec<usize> {
    let is_double = |chunk: &PlanChunk| chunk.mode == SupportMode::Double as u32;
    (1..chunks.len()).filter(|&index| is_double(&chunks[index]) && !is_double(&chunks[index - 1])).collect()
}

/// Replans at a landing whose ground turns out to be missing; answers the rest of the way.
fn replan_at_landing(case: &Case, landing: usize) -> (Vec<PlanChunk>, Correction) {
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let at = landings(&chunks)[landing];
    let mut walker = case.walker();
    let standing = walk(&mut walker, &chunks[..at], Standing::zeroed());
    let lifted = if standing.mode == SupportMode::Left as u32 { 1 } else { 0 };
    let landed = chunks[at].contacts().iter().find(|contact| contact.limb == lifted).unwrap();
    let correction = Correction::contact_missing(&landed.world_from_sole(), [0.1, 0.05]);
    walker.correct(&correction);
    let stale = walker.admit_and_walk(&addressed(&chunks[at])).unwrap_err();
    assert_eq!(stale.check, Check::World, "a plan for the world as it was believed is refused now");
    let corrected = case.world.corrected(&[correction]).unwrap();
    let rest = case.plan(&corrected, Some(&correction), Some(&standing), 1).unwrap();
    assert!((1..rest.len()).all(|index| rest[index].epoch == 1) && rest[0].mode != SupportMode::Double as u32);
    walk(&mut walker, &rest, standing);
    assert!(walker.finished());
    (rest, correction)
}

#[test]
fn the_robot_goes_on_from_one_foot_and_shuns_the_place_that_did_not_carry() {
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
fn the_robot_goes_on_from_both_feet() {
    let case = Case::load("flat_walk");
    let chunks = case.plan(&case.world, None, None, 0).unwrap();
    let both = (0..chunks.len()).filter(|&index| chunks[index].mode == SupportMode::Double as u32).nth(3).unwrap();
    let mut walker = case.walker();
    let standing = walk(&mut walker, &chunks[..=both], Standing::zeroed());
    let rest = case.plan(&case.world, None, Some(&standing), 1).unwrap();
    walk(&mut walker, &rest, standing);
    assert!(walker.finished());
}

#[test]
fn replanning_can_be_made_again() {
    let case = Case::load("stepping_stones");
    let digest = |chunks: &[PlanChunk]| chunks.last().unwrap().stream_after();
    let [first, second] = [0, 1].map(|_| replan_at_landing(&case, 2).0);
    assert_eq!(digest(&first), digest(&second));
}
