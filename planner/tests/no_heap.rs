//! A built planner allocates no memory until its outcome, on any thread. The test is alone in its
//! file because the allocator counts for the whole process.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use std::num::NonZeroUsize;

use common::{Case, WALKS, preparation_for, run};
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_planner::pipeline::outcome::Bound;
use surefoot_planner::{Outcome, Planner};

/// A rough mesh and, in an optimised build, a course of several segments.
const OTHER_WALKS: &[&str] =
    if cfg!(debug_assertions) { &["rough_ground"] } else { &["rough_ground", "gauntlet_1"] };

/// Allocations of all threads while `search` runs.
fn allocations_of<T>(search: impl FnOnce() -> T) -> (usize, T) {
    let before = allocations::count();
    let result = search();
    (allocations::count() - before, result)
}

/// The other methods that allocate on a short walk.
fn methods_that_allocate() -> Vec<String> {
    let mut case = Case::shipped("flat_walk");
    case.scenario.goal.position = case.scenario.start.position + 0.9 * glam::DVec3::X;
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    let allocations_by = |method: Method| {
        let mut planner =
            Planner::builder(&case.model, &case.world, &case.scenario, preparation.clone())
                .method(method, MethodParameters::default())
                .build()
                .unwrap();
        planner.limit_work(200_000);
        allocations_of(|| run(&mut planner, u64::MAX)).0
    };
    let others = Method::ALL.into_iter().filter(|method| *method != Method::Rpg);
    let allocates = |method: &Method| allocations_by(*method) > 0 && allocations_by(*method) > 0;
    others.filter(allocates).map(|method| method.name().to_owned()).collect()
}

/// Allocations while a smooth walk is planned and improved.
fn allocations_of_an_improvement() -> usize {
    let case = Case::smooth("ibeam_hallway");
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    let allocations = || {
        let mut planner =
            Planner::builder(&case.model, &case.world, &case.scenario, preparation.clone())
                .threads(NonZeroUsize::MIN.saturating_add(1))
                .improve(40_000)
                .build()
                .unwrap();
        allocations_of(|| run(&mut planner, 1_000)).0
    };
    allocations().min(allocations())
}

/// The only test of the file, so that no other one allocates at the same time.
#[test]
fn a_built_planner_allocates_no_memory() {
    let (counted, _) = allocations_of(|| std::hint::black_box(Box::new(1)));
    assert_eq!(counted, 1, "the allocator counts");
    let infeasible =
        Case::shipped("no_way_ceiling").configured(|planner| planner.work_max = 50_000);
    let walks = WALKS.iter().chain(OTHER_WALKS).map(|walk| (Case::shipped(walk), Outcome::Found));
    let walks = walks.chain([(Case::smooth("flat_walk"), Outcome::Found)]);
    let mut failures = vec![];
    for (case, expected) in walks.chain([(infeasible, Outcome::BudgetExhausted(Bound::Work))]) {
        for (threads, work_per_step) in [(1, u64::MAX), (2, 1_000), (3, u64::MAX)] {
            let search = || {
                let mut planner = case.planner(threads);
                let (allocations, outcome) = allocations_of(|| run(&mut planner, work_per_step));
                assert_eq!(outcome, expected, "{}", case.scenario.name);
                allocations
            };
            // The test harness allocates once, for its message that a test takes a minute.
            let allocations = match search() {
                0 => 0,
                first => first.min(search()),
            };
            if allocations > 0 {
                failures
                    .push(format!("{} on {threads} threads: {allocations}", case.scenario.name));
            }
        }
    }
    failures.extend(methods_that_allocate());
    match allocations_of_an_improvement() {
        0 => {}
        count => failures.push(format!("an improvement: {count}")),
    }
    assert!(failures.is_empty(), "allocations before the outcome: {failures:#?}");
}
