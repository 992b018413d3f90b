//! The allocator: counts heap allocations, to show that a search makes none, and ends the process
//! with one line where the system has no more memory for it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::system::fixed_text::FixedText;

/// The exit code of a process that gets no memory: its environment is bad.
const EXIT_CODE: libc::c_int = 2;

static COUNT: AtomicU64 = AtomicU64::new(0);
static IS_ROLE: AtomicBool = AtomicBool::new(false);

/// The system's allocator with a counter. A binary that counts sets it as its global allocator.
#[derive(Debug, Clone, Copy)]
pub struct CountingAllocator;

/// Allocations and reallocations of all threads so far; 0 where [`CountingAllocator`] is not the
/// global allocator.
pub fn count() -> u64 {
    COUNT.load(Ordering::Relaxed)
}

/// Reports a lack of memory to the supervisor, by an event on stdout.
pub fn report_to_supervisor() {
    IS_ROLE.store(true, Ordering::Relaxed);
}

/// Ends the process. Unwinding, and the message of a panic, would need memory again.
fn end_without_memory(bytes: usize) -> ! {
    let mut line = FixedText::<256>::default();
    let reason = "the system has no more memory for this process";
    let advice = "raise the limit ('ulimit -v', the container's), or use fewer --threads";
    let text = format_args!("{reason} ({bytes} bytes refused); {advice}");
    if IS_ROLE.load(Ordering::Relaxed) {
        line.push(format_args!("{{\"event\":\"failed\",\"message\":\"{text}\"}}\n"));
        line.write_to(libc::STDOUT_FILENO);
    } else {
        line.push(format_args!("error: {text}\n"));
        line.write_to(libc::STDERR_FILENO);
    }
    // SAFETY: it ends the process.
    unsafe { libc::_exit(EXIT_CODE) }
}

fn checked(block: *mut u8, bytes: usize) -> *mut u8 {
    if block.is_null() { end_without_memory(bytes) } else { block }
}

// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract. An
// allocator may end the process.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        checked(unsafe { System.realloc(block, layout, new_size) }, new_size)
    }
}
