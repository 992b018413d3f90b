//! A planner that is ready never touches the heap until it has its outcome, on any thread. Alone in its file: the
//! allocator counts for the whole process.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Case, WALKS, run};
use surefoot_planner::Outcome;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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

/// Allocations of all threads while `search` runs.
fn allocations_of<T>(search: impl FnOnce() -> T) -> (usize, T) {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let result = search();
    (ALLOCATIONS.load(Ordering::Relaxed) - before, result)
}

/// One test, so that no other one allocates meanwhile.
#[test]
fn a_ready_planner_never_touches_the_heap() {
    let (seen, _) = allocations_of(|| std::hint::black_box(Box::new(1)));
    assert_eq!(seen, 1, "the allocator counts");
    let mut guilty = vec![];
    for walk in WALKS {
        for threads in [1, 2] {
            let mut planner = Case::shipped(walk).planner(threads);
            let (allocations, outcome) = allocations_of(|| run(&mut planner, 1_000));
            assert_eq!(outcome, Outcome::Found, "{walk}");
            if allocations > 0 {
                guilty.push(format!("{walk} on {threads} threads: {allocations}"));
            }
        }
    }
    let mut hopeless = Case::shipped("no_way_wall").configured(|planner| planner.work_max = 100_000).planner(2);
    let (allocations, _) = allocations_of(|| run(&mut hopeless, 1_000));
    if allocations > 0 {
        guilty.push(format!("no_way_wall: {allocations}"));
    }
    assert!(guilty.is_empty(), "allocations between ready and outcome: {guilty:#?}");
}
