//! What happens to a walk after its motions are found, and how long ones are put together.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, run};
use surefoot_planner::Outcome;

fn steps(name: &str, seed: u64, shorten_rounds_max: u32) -> u64 {
    let case = Case::shipped(name).with_seed(seed).configured(|planner| planner.shorten_rounds_max = shorten_rounds_max);
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    planner.steps()
}

#[test]
fn a_walk_loses_needless_steps() {
    let pairs: Vec<[u64; 2]> = (1..6).map(|seed| [0, 6].map(|rounds| steps("stairs", seed, rounds))).collect();
    assert!(pairs.iter().all(|[as_found, shortened]| shortened <= as_found), "{pairs:?}");
    assert!(pairs.iter().any(|[as_found, shortened]| shortened < as_found), "{pairs:?}");
}

/// With stations so near to each other the route has more than two segments' worth of them, and each takes a search of its own.
#[test]
fn a_long_walk_stands_between_its_segments() {
    let case = Case::shipped("flat_walk").configured(|planner| planner.station_spacing = 0.1);
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    assert!(planner.tally().sequences >= 2, "the route was not cut");
    let mut at = planner.chunks()[0].waypoints[0].world_from_root().translation;
    for chunk in planner.chunks() {
        let first = chunk.waypoints[0].world_from_root().translation;
        assert!(first.distance(at) < 1e-9, "a segment begins elsewhere than the one before it ends");
        at = chunk.waypoints[chunk.waypoints_len as usize - 1].world_from_root().translation;
    }
}
