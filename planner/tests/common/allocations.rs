//! An allocator that counts the allocations of the whole process, except those of the test
//! harness, which runs on the main thread beside the test.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The system's allocator with a counter.
struct CountingAllocator;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
/// Whether the test itself runs on the main thread, as with one test thread.
static COUNTS_MAIN_THREAD: AtomicBool = AtomicBool::new(false);

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Allocations and reallocations of this process so far. Call it on the thread of the test; each
/// call makes sure that an allocation there is counted.
pub fn count() -> usize {
    COUNTS_MAIN_THREAD.store(is_main_thread(), Ordering::Relaxed);
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    drop(std::hint::black_box(Box::new(before)));
    let after = ALLOCATIONS.fetch_sub(1, Ordering::Relaxed);
    assert!(after > before, "an allocation of the test is not counted");
    after - 1
}

fn count_one() {
    if COUNTS_MAIN_THREAD.load(Ordering::Relaxed) || !is_main_thread() {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
    }
}

fn is_main_thread() -> bool {
    // SAFETY: neither call can fail or touches memory.
    unsafe { libc::gettid() == libc::getpid() }
}

// SAFETY: every call is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_one();
        // SAFETY: the caller meets the same requirements.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count_one();
        // SAFETY: the caller meets the same requirements.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count_one();
        // SAFETY: the caller meets the same requirements.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller meets the same requirements.
        unsafe { System.dealloc(pointer, layout) }
    }
}
