//! Small worlds in which a search without one of its last resorts finds nothing, and the whole
//! search a walk: docs/COMPLETENESS.md. `surefoot bench holes` searches all of them with more
//! seeds.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, repository, run};
use glam::DVec3;
use surefoot_planner::pipeline::SearchStats;
use surefoot_planner::pipeline::resorts::Resort;
use surefoot_planner::{Outcome, Planner};
use surefoot_shared_types::world::load::load_world;

/// Seeds of each world.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=4;

/// A world of a hole, walked from x = 0.7 m to x = `goal` (m).
fn hole(name: &str, goal: f64, seed: u64, work_max: u64) -> Case {
    let mut case = Case::shipped("flat_walk").with_seed(seed);
    let path = repository().join(format!("configs/worlds/holes/{name}.toml"));
    case.world = load_world(&path).unwrap();
    case.scenario.start.position = 0.7 * DVec3::X;
    case.scenario.goal.position = goal * DVec3::X;
    case.configured(|planner| planner.work_max = work_max)
}

/// How a search ends, with its statistics.
fn ending(case: &Case, prepare: impl Fn(&mut Planner)) -> (Outcome, SearchStats) {
    let mut planner = case.planner(2);
    prepare(&mut planner);
    (run(&mut planner, u64::MAX), planner.stats())
}

/// Leaves out a last resort, and the coarse path, which passes some holes by.
fn without(planner: &mut Planner, resort: Resort) {
    planner.leave_out(resort);
    planner.search_on();
}

#[test]
fn a_wall_that_is_longer_than_the_first_region_is_walked_around() {
    for seed in SEEDS {
        let (outcome, stats) = ending(&hole("long_wall", 2.7, seed, 200_000), |_| {});
        assert_eq!(outcome, Outcome::Found, "seed {seed}: {stats:?}");
    }
    let case = hole("long_wall", 2.7, 1, 100_000);
    let (outcome, _) = ending(&case, |planner| without(planner, Resort::WiderRegion));
    assert_ne!(outcome, Outcome::Found);
}

#[test]
fn another_posture_is_found_at_a_goal_whose_first_one_cannot_be_reached() {
    for seed in SEEDS {
        let case = hole("pillory", 3.0, seed, 100_000);
        let (outcome, stats) = ending(&case, |_| {});
        assert_eq!(outcome, Outcome::Found, "seed {seed}: {stats:?}");
        assert!(stats.goal_postures > 0, "seed {seed}: {stats:?}");
    }
    let case = hole("pillory", 3.0, 1, 100_000);
    let (outcome, _) = ending(&case, |planner| planner.leave_out(Resort::GoalPostures));
    assert_ne!(outcome, Outcome::Found);
}

#[test]
fn footholds_that_only_the_checker_accepts_are_used_where_there_are_no_others() {
    for seed in SEEDS {
        let case = hole("pegs", 4.5, seed, 60_000);
        let (outcome, stats) = ending(&case, |_| {});
        assert_eq!(outcome, Outcome::Found, "seed {seed}: {stats:?}");
        assert!(stats.has_least_margins, "seed {seed}: {stats:?}");
    }
    let case = hole("pegs", 4.5, 1, 60_000);
    let (outcome, _) = ending(&case, |planner| planner.leave_out(Resort::LeastMargins));
    assert_ne!(outcome, Outcome::Found);
}

#[test]
fn the_root_leans_where_no_upright_route_is_free() {
    for seed in SEEDS {
        let case = hole("low_beam", 4.3, seed, 200_000);
        let (outcome, stats) = ending(&case, |_| {});
        assert_eq!(outcome, Outcome::Found, "seed {seed}: {stats:?}");
        assert!(stats.leaning_routes > 0, "seed {seed}: {stats:?}");
    }
    let case = hole("low_beam", 4.3, 1, 200_000);
    let (outcome, stats) = ending(&case, |planner| without(planner, Resort::LeaningRoot));
    assert_ne!(outcome, Outcome::Found);
    assert_eq!(stats.leaning_routes, 0);
}

/// The dead end with so many live routes.
fn dead_end(live_routes: u32, seed: u64) -> Case {
    hole("dead_end", 5.3, seed, 200_000).configured(|planner| planner.live_routes = live_routes)
}

#[test]
fn two_live_routes_leave_a_dead_end_sooner() {
    let found_with = |live_routes: u32| {
        let endings = (1..=6).map(|seed| {
            let upright = |planner: &mut Planner| planner.leave_out(Resort::LeaningRoot);
            ending(&dead_end(live_routes, seed), upright)
        });
        let found = endings.filter(|(outcome, stats)| {
            assert!(live_routes > 1 || stats.turns == 0);
            *outcome == Outcome::Found
        });
        found.count()
    };
    assert_eq!(found_with(2), 6);
    assert!(found_with(1) < 6);
}

#[test]
fn turns_between_live_routes_depend_on_neither_threads_nor_steps() {
    let search = |threads: usize, step: u64| {
        let mut planner = dead_end(3, 2).planner(threads);
        let outcome = run(&mut planner, step);
        (outcome, planner.digest(), planner.stats())
    };
    let alone = search(1, u64::MAX);
    assert!(alone.0 == Outcome::Found && alone.2.turns > 0, "{alone:?}");
    assert_eq!(search(2, 777), alone);
    assert_eq!(search(4, 1), alone);
}
