//! The same inputs give the same plan, byte for byte: however often, on however many threads, in however large steps,
//! and in every build.
//!
//! The digests in `tests/data/golden_digests.txt` are those of the walks with their shipped seeds. After a change that is
//! meant to change plans, `SUREFOOT_BLESS=1 cargo test -p surefoot-planner --test determinism` rewrites them.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, WALKS, repository, run};
use surefoot_planner::Outcome;
use surefoot_planner::rpg::Tally;
use surefoot_shared_types::digest::Digest;

const GOLDEN: &str = "tests/data/golden_digests.txt";
const STEP: u64 = 20_000;

fn plan(case: &Case, threads: usize, step: u64) -> (Digest, Tally) {
    let mut planner = case.planner(threads);
    assert_eq!(run(&mut planner, step), Outcome::Found, "{}", case.scenario.name);
    (planner.digest(), planner.tally())
}

#[test]
fn a_plan_can_be_made_again() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        assert_eq!(plan(&case, 2, STEP), plan(&case, 2, STEP), "{walk}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        let alone = plan(&case, 1, STEP);
        for threads in [2, 3, 4] {
            assert_eq!(plan(&case, threads, STEP), alone, "{walk} on {threads} threads");
        }
    }
}

#[test]
fn the_size_of_steps_changes_nothing() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        let smallest = plan(&case, 2, 1);
        for step in [1_000, u64::MAX] {
            assert_eq!(plan(&case, 2, step), smallest, "{walk} in steps of {step}");
        }
    }
}

#[test]
fn an_unsuccessful_search_can_be_made_again() {
    let case = Case::shipped("no_way_wall").configured(|planner| planner.work_max = 8_000);
    let search = |threads, step| {
        let mut planner = case.planner(threads);
        (run(&mut planner, step), planner.tally())
    };
    let alone = search(1, u64::MAX);
    assert_eq!(search(4, 1), alone);
    assert_eq!(search(2, 777), alone);
}

#[test]
fn another_seed_gives_another_plan() {
    let digests: Vec<Digest> = [1, 2, 3].map(|seed| plan(&Case::shipped("ibeam_gap").with_seed(seed), 2, STEP).0).into();
    assert!(digests[0] != digests[1] && digests[1] != digests[2] && digests[0] != digests[2]);
}

#[test]
fn another_seed_moves_the_robot_otherwise_where_it_must_sample() {
    let waypoints = |seed| {
        let mut planner = Case::shipped("ibeam_gap").with_seed(seed).planner(2);
        assert_eq!(run(&mut planner, STEP), Outcome::Found);
        let waypoints = planner.chunks().iter().flat_map(|chunk| chunk.waypoints().to_vec());
        waypoints.map(|waypoint| waypoint.root_position).collect::<Vec<_>>()
    };
    let first = waypoints(1);
    assert!((2..=5).any(|seed| waypoints(seed) != first), "five seeds, one motion: does the search draw from its streams?");
}

#[test]
fn every_build_makes_the_plans_it_always_made() {
    let lines = WALKS.map(|walk| format!("{walk} {}\n", plan(&Case::shipped(walk), 2, STEP).0));
    let path = repository().join(GOLDEN);
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        std::fs::write(&path, lines.concat()).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(lines.concat(), golden, "plans have changed; if they were meant to, bless {GOLDEN} as this test's file says");
}
