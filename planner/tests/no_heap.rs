//! A planner that is ready does not touch the heap until it has its outcome, on any thread. Alone in its file: the
//! allocator counts for the whole process.
//!
//! One thing is beyond the planner: each round of its search enters rayon's pool through a queue, for which rayon
//! allocates a block of some sixty slots whenever the last one is used up. These blocks are known by their size, which is
//! measured first, and counted apart.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Case, WALKS, run};
use surefoot_planner::Outcome;
use surefoot_planner::outcome::Bound;

struct Counting;

/// Allocations of a size that is not [`QUEUE_BLOCK`].
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
/// Allocations of the size [`QUEUE_BLOCK`].
static QUEUE_BLOCKS: AtomicUsize = AtomicUsize::new(0);
/// Bytes of a block of rayon's queue; 0 until it is known.
static QUEUE_BLOCK: AtomicUsize = AtomicUsize::new(0);
/// Bytes of the allocation before.
static LAST_SIZE: AtomicUsize = AtomicUsize::new(0);

fn note(size: usize) {
    let is_block = size == QUEUE_BLOCK.load(Ordering::Relaxed);
    let count = if is_block { &QUEUE_BLOCKS } else { &ALLOCATIONS };
    count.fetch_add(1, Ordering::Relaxed);
    LAST_SIZE.store(size, Ordering::Relaxed);
}

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promises are handed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
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

/// Allocations of all threads while `search` runs: those of the planner, and the blocks of rayon's queue.
fn allocations_of<T>(search: impl FnOnce() -> T) -> ([usize; 2], T) {
    let now = || [&ALLOCATIONS, &QUEUE_BLOCKS].map(|count| count.load(Ordering::Relaxed));
    let before = now();
    let result = search();
    let after = now();
    ([0, 1].map(|kind| after[kind] - before[kind]), result)
}

/// Measures the block of rayon's queue: all that rayon allocates while it is handed a thousand empty jobs.
fn measure_queue_block() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| ());
    let rounds = || (0..1_000).for_each(|_| pool.install(|| ()));
    let ([first, _], ()) = allocations_of(rounds);
    QUEUE_BLOCK.store(LAST_SIZE.load(Ordering::Relaxed), Ordering::Relaxed);
    let (second, ()) = allocations_of(rounds);
    assert!((1..=20).contains(&first) && second[0] == 0 && second[1] > 0, "rayon allocates otherwise: {first}, {second:?}");
}

/// One test, so that no other one allocates meanwhile.
#[test]
fn a_ready_planner_never_touches_the_heap() {
    let (seen, _) = allocations_of(|| std::hint::black_box(Box::new(1)));
    assert_eq!(seen, [1, 0], "the allocator counts");
    measure_queue_block();
    let hopeless = Case::shipped("no_way_wall").configured(|planner| planner.work_max = 100_000);
    let walks = WALKS.map(|walk| (Case::shipped(walk), Outcome::Found));
    let mut guilty = vec![];
    for (case, expected) in walks.into_iter().chain([(hopeless, Outcome::BudgetExhausted(Bound::Work))]) {
        for threads in [1, 2] {
            let mut planner = case.planner(threads);
            let ([allocations, _], outcome) = allocations_of(|| run(&mut planner, 1_000));
            assert_eq!(outcome, expected, "{}", case.scenario.name);
            if allocations > 0 {
                guilty.push(format!("{} on {threads} threads: {allocations}", case.scenario.name));
            }
        }
    }
    assert!(guilty.is_empty(), "allocations between ready and outcome: {guilty:#?}");
}
