//! Long walks consist of segments that are planned in parallel [Grey 3.2].

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, run};
use surefoot_planner::{Outcome, Planner};

/// A walk whose route vertices are so close to each other that the route has several segments.
fn long_walk(threads: usize, step: u64) -> Planner {
    let case = Case::shipped("flat_walk").configured(|planner| planner.route_vertex_spacing = 0.1);
    let mut planner = case.planner(threads);
    assert_eq!(run(&mut planner, step), Outcome::Found);
    planner
}

#[test]
fn a_segment_begins_where_the_previous_one_ends() {
    let planner = long_walk(1, u64::MAX);
    assert!(planner.stats().sequences >= 2, "the route has one segment");
    let mut at = planner.chunks()[0].waypoints[0].world_from_root().translation;
    for chunk in planner.chunks() {
        let first = chunk.waypoints[0].world_from_root().translation;
        assert!(first.distance(at) < 1e-9, "a chunk begins elsewhere than the previous one ends");
        at = chunk.waypoints[chunk.waypoints_len as usize - 1].world_from_root().translation;
    }
}

#[test]
fn segments_are_planned_in_parallel() {
    assert!(long_walk(1, u64::MAX).stats().segments_at_once > 1);
    let short = Case::shipped("ibeam_gap");
    let mut planner = short.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    assert_eq!(planner.stats().segments_at_once, 1, "a short route is one segment");
}

#[test]
fn threads_and_budgets_do_not_change_a_walk_of_several_segments() {
    let alone = long_walk(1, u64::MAX);
    for (threads, step) in [(2, 1), (3, 777), (4, 20_000)] {
        let planner = long_walk(threads, step);
        assert_eq!(
            (planner.digest(), planner.stats()),
            (alone.digest(), alone.stats()),
            "{threads} threads, {step} work units per step"
        );
    }
}

/// A scenario of two segments, one of which is solved on the second route only.
#[test]
#[cfg_attr(debug_assertions, ignore = "takes minutes in a debug build")]
fn threads_and_budgets_do_not_change_a_walk_on_a_second_route() {
    let case = Case::shipped("gauntlet_1").with_seed(136);
    let walk = |threads, step| {
        let mut planner = case.planner(threads);
        assert_eq!(run(&mut planner, step), Outcome::Found);
        (planner.digest(), planner.stats())
    };
    let alone = walk(1, u64::MAX);
    assert!(alone.1.routes > 1 && alone.1.segments_at_once > 1, "{:?}", alone.1);
    for (threads, step) in [(2, 1), (2, 20_000), (4, 777)] {
        assert_eq!(walk(threads, step), alone, "{threads} threads, {step} work units per step");
    }
}
