//! The memory of the protocol between threads.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::base::threads::tuning::WAIT_POLLS_MAX;

/// A machine word that threads share, sequentially consistent. A test supplies words of its own to
/// run every order of accesses.
pub trait Word: Send + Sync {
    /// A word with a value.
    fn new(value: u64) -> Self;

    /// Its value.
    fn load(&self) -> u64;

    /// Sets its value.
    fn store(&self, value: u64);

    /// Sets its value to `new` if it is `current`. Returns whether it was.
    fn replace(&self, current: u64, new: u64) -> bool;

    /// Subtracts one.
    fn decrement(&self);

    /// Lets other threads proceed, for the n-th time in a wait for them.
    fn pause(count: u32);
}

impl Word for AtomicU64 {
    fn new(value: u64) -> Self {
        Self::new(value)
    }

    fn load(&self) -> u64 {
        Self::load(self, Ordering::SeqCst)
    }

    fn store(&self, value: u64) {
        Self::store(self, value, Ordering::SeqCst);
    }

    fn replace(&self, current: u64, new: u64) -> bool {
        self.compare_exchange(current, new, Ordering::SeqCst, Ordering::SeqCst).is_ok()
    }

    fn decrement(&self) {
        self.fetch_sub(1, Ordering::SeqCst);
    }

    fn pause(count: u32) {
        if count < WAIT_POLLS_MAX {
            std::hint::spin_loop();
        } else {
            std::thread::yield_now();
        }
    }
}
