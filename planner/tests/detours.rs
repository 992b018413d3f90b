//! A wall on a bare floor, between start and goal: the walk leads around its end, however far that
//! is beyond the region in which stage P begins to sample.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, run};
use glam::DVec3;
use surefoot_planner::Outcome;

/// Work that a detour may take. Most takes the relaxed problem, which surveys the floor.
const WORK_MAX: u64 = 60_000;

/// A wall along y of half this length (m), on a square floor with half this side (m).
fn wall(half_length: f64, half_side: f64, seed: u64, work_max: u64) -> Case {
    let mut case = Case::shipped("flat_walk").with_seed(seed);
    case.world.shapes.clear();
    (case.scenario.start.position, case.scenario.goal.position) = (DVec3::NEG_X, DVec3::X);
    case.with_box([0.0, 0.0, -0.25], [half_side, half_side, 0.25])
        .with_box([0.0, 0.0, 1.0], [0.05, half_length, 1.0])
        .configured(move |planner| planner.work_max = work_max)
}

#[test]
fn walls_of_any_length_are_walked_around() {
    for half_length in [3.0, 4.0, 5.0, 6.0, 8.0, 11.0] {
        for seed in [1, 6] {
            let mut planner = wall(half_length, 12.0, seed, WORK_MAX).planner(2);
            let outcome = run(&mut planner, u64::MAX);
            assert_eq!(outcome, Outcome::Found, "half length {half_length} m, seed {seed}");
        }
    }
}

#[test]
fn a_wall_across_the_whole_floor_ends_without_a_route() {
    let mut planner = wall(4.0, 4.0, 1, 400_000).planner(2);
    assert_ne!(run(&mut planner, u64::MAX), Outcome::Found);
    let stats = planner.stats();
    assert!(stats.has_least_margins, "stage P has searched the whole floor: {stats:?}");
    assert!(stats.used_straight_line || stats.routes_under_c_n > 0, "{stats:?}");
}
