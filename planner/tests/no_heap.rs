//! A planner that is ready does not touch the heap until it has its outcome, on any thread. Alone
//! in its file: the allocator counts for the whole process.
//!
//! With several threads each call of `step` enters rayon's pool through a queue, for which rayon
//! allocates a block every sixty calls or so; a search made in one call meets none.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Case, WALKS, run};
use surefoot_planner::Outcome;
use surefoot_planner::pipeline::outcome::Bound;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

fn note() {
    ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
}

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are handed on.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A rough mesh; and, where the build is optimised, a course of several segments.
const OTHER_WALKS: &[&str] =
    if cfg!(debug_assertions) { &["rough_ground"] } else { &["rough_ground", "gauntlet_1"] };

/// Allocations of all threads while `search` runs.
fn allocations_of<T>(search: impl FnOnce() -> T) -> (usize, T) {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let result = search();
    (ALLOCATIONS.load(Ordering::Relaxed) - before, result)
}

/// Threads of this process.
fn threads_alive() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// One test, so that no other one allocates meanwhile.
#[test]
fn a_ready_planner_never_touches_the_heap() {
    let (seen, _) = allocations_of(|| std::hint::black_box(Box::new(1)));
    assert_eq!(seen, 1, "the allocator counts");
    let hopeless = Case::shipped("no_way_wall").configured(|planner| planner.work_max = 100_000);
    let walks = WALKS.iter().chain(OTHER_WALKS).map(|walk| (Case::shipped(walk), Outcome::Found));
    let mut guilty = vec![];
    for (case, expected) in walks.chain([(hopeless, Outcome::BudgetExhausted(Bound::Work))]) {
        for (threads, work_per_step) in [(1, 1_000), (1, u64::MAX), (2, u64::MAX)] {
            let others = threads_alive();
            let mut planner = case.planner(threads);
            let (allocations, outcome) = allocations_of(|| run(&mut planner, work_per_step));
            drop(planner);
            // A pool's threads end after it, and may allocate while they do.
            while threads > 1 && threads_alive() > others {
                std::thread::yield_now();
            }
            assert_eq!(outcome, expected, "{}", case.scenario.name);
            if allocations > 0 {
                guilty.push(format!("{} on {threads} threads: {allocations}", case.scenario.name));
            }
        }
    }
    assert!(guilty.is_empty(), "allocations between ready and outcome: {guilty:#?}");
}
