//! A built planner allocates no memory until its outcome, on any thread. The test is alone in its
//! file because the allocator counts for the whole process.
//!
//! With several threads each call of `step` enters rayon's pool through a queue, for which rayon
//! allocates a block about every sixty calls; a search in one call allocates none.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use common::{Case, WALKS, run};
use surefoot_planner::Outcome;
use surefoot_planner::pipeline::outcome::Bound;
use surefoot_shared_types::config::MotionKind;

/// A rough mesh and, in an optimised build, a course of several segments.
const OTHER_WALKS: &[&str] =
    if cfg!(debug_assertions) { &["rough_ground"] } else { &["rough_ground", "gauntlet_1"] };

/// Allocations of all threads while `search` runs.
fn allocations_of<T>(search: impl FnOnce() -> T) -> (usize, T) {
    let before = allocations::count();
    let result = search();
    (allocations::count() - before, result)
}

/// Number of threads of this process.
fn threads_alive() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// The only test of the file, so that no other one allocates at the same time.
#[test]
fn a_built_planner_allocates_no_memory() {
    let (counted, _) = allocations_of(|| std::hint::black_box(Box::new(1)));
    assert_eq!(counted, 1, "the allocator counts");
    let infeasible = Case::shipped("no_way_wall").configured(|planner| planner.work_max = 100_000);
    let walks = WALKS.iter().chain(OTHER_WALKS).map(|walk| (Case::shipped(walk), Outcome::Found));
    let mut smooth = Case::shipped("flat_walk");
    smooth.scenario.execution.motion = MotionKind::Smooth;
    let walks = walks.chain([(smooth, Outcome::Found)]);
    let mut failures = vec![];
    for (case, expected) in walks.chain([(infeasible, Outcome::BudgetExhausted(Bound::Work))]) {
        for (threads, work_per_step) in [(1, 1_000), (1, u64::MAX), (2, u64::MAX)] {
            let others = threads_alive();
            let mut planner = case.planner(threads);
            let (allocations, outcome) = allocations_of(|| run(&mut planner, work_per_step));
            drop(planner);
            // The pool's threads end later and may allocate as they end.
            while threads > 1 && threads_alive() > others {
                std::thread::yield_now();
            }
            assert_eq!(outcome, expected, "{}", case.scenario.name);
            if allocations > 0 {
                failures
                    .push(format!("{} on {threads} threads: {allocations}", case.scenario.name));
            }
        }
    }
    assert!(failures.is_empty(), "allocations before the outcome: {failures:#?}");
}
