//! Steps are removed from a walk after its motions are found [Grey 4.4.6].

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, run};
use surefoot_planner::Outcome;

/// Number of steps of a walk that is found with at most as many rounds of step removal.
fn steps(name: &str, seed: u64, step_removal_rounds_max: u32) -> u64 {
    let case = Case::shipped(name)
        .with_seed(seed)
        .configured(|planner| planner.step_removal_rounds_max = step_removal_rounds_max);
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    planner.steps()
}

#[test]
fn unnecessary_steps_are_removed() {
    let pairs: Vec<[u64; 2]> =
        (1..6).map(|seed| [0, 6].map(|rounds| steps("spiral_steps", seed, rounds))).collect();
    assert!(pairs.iter().all(|[as_found, reduced]| reduced <= as_found), "{pairs:?}");
    assert!(pairs.iter().any(|[as_found, reduced]| reduced < as_found), "{pairs:?}");
}
