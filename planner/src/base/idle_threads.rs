//! Idle threads of a pool: they poll for work, then sleep until they are woken.
//!
//! Rayon's own threads sleep after about 15 µs, and waking one takes 50 µs or more on virtual
//! cores: longer than most work items.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::Yield;

use crate::base::tuning::IDLE_POLLS_MAX;

/// State of the pool's threads while one of them runs a task and shares parts of it.
#[derive(Debug)]
pub struct IdleThreads {
    /// By thread: whether it is already in [`IdleThreads::run_with_idle`], as the running thread or
    /// as a polling one.
    is_entered: Vec<AtomicBool>,
    is_over: AtomicBool,
    asleep: AtomicUsize,
    /// Number of wake-ups so far.
    wake_count: Mutex<u64>,
    wake_signal: Condvar,
}

impl IdleThreads {
    /// The state of a pool with this number of threads.
    pub fn new(threads: usize) -> Self {
        Self {
            is_entered: (0..threads).map(|_| AtomicBool::new(false)).collect(),
            is_over: AtomicBool::new(false),
            asleep: AtomicUsize::new(0),
            wake_count: Mutex::new(0),
            wake_signal: Condvar::new(),
        }
    }

    /// Runs `work` while the pool's other threads poll for shared parts of it. Must be called
    /// within the pool.
    pub fn run_with_idle<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.is_over.store(false, Ordering::SeqCst);
        let work = || {
            let _entered = self.enter();
            let _stop = StopGuard(self);
            work()
        };
        self.with_others(self.is_entered.len() - 1, work)
    }

    /// Wakes all sleeping threads. Called when there is work to share.
    pub fn wake(&self) {
        fence(Ordering::SeqCst);
        if self.asleep.load(Ordering::SeqCst) > 0 {
            *self.wake_count.lock().unwrap_or_else(PoisonError::into_inner) += 1;
            self.wake_signal.notify_all();
        }
    }

    fn with_others<T: Send>(&self, others: usize, work: impl FnOnce() -> T + Send) -> T {
        if others == 0 {
            return work();
        }
        rayon::join(|| self.with_others(others - 1, work), || self.poll_for_work()).0
    }

    /// Runs shared work until `run_with_idle` is over. A thread that waits for another may pick up
    /// this function too; `enter` makes it return at once.
    fn poll_for_work(&self) {
        let Some(_entered) = self.enter() else { return };
        while !self.is_over.load(Ordering::SeqCst) {
            if !poll(IDLE_POLLS_MAX, || self.is_over.load(Ordering::Relaxed)) {
                self.sleep();
            }
        }
    }

    fn sleep(&self) {
        let known = *self.wake_count.lock().unwrap_or_else(PoisonError::into_inner);
        self.asleep.fetch_add(1, Ordering::SeqCst);
        fence(Ordering::SeqCst);
        // Work that was shared before this thread counted as asleep woke no thread.
        if rayon::yield_now() != Some(Yield::Executed) && !self.is_over.load(Ordering::SeqCst) {
            let wake_count = self.wake_count.lock().unwrap_or_else(PoisonError::into_inner);
            drop(
                self.wake_signal
                    .wait_while(wake_count, |wake_count| *wake_count == known)
                    .unwrap_or_else(PoisonError::into_inner),
            );
        }
        self.asleep.fetch_sub(1, Ordering::SeqCst);
    }

    /// Marks this thread as entered; `None` if it is already.
    fn enter(&self) -> Option<Entered<'_>> {
        let is_entered = &self.is_entered[rayon::current_thread_index()?];
        (!is_entered.swap(true, Ordering::Relaxed)).then_some(Entered(is_entered))
    }
}

/// Polls at most `polls_max` times for shared work and runs it. Returns whether a poll found work
/// or `is_done` became true.
pub fn poll(polls_max: u32, is_done: impl Fn() -> bool) -> bool {
    for _ in 0..polls_max {
        if is_done() || rayon::yield_now() == Some(Yield::Executed) {
            return true;
        }
        std::hint::spin_loop();
    }
    false
}

/// Ends the polling of the other threads when it is dropped, also on a panic.
struct StopGuard<'a>(&'a IdleThreads);

impl Drop for StopGuard<'_> {
    fn drop(&mut self) {
        self.0.is_over.store(true, Ordering::SeqCst);
        self.0.wake();
    }
}

struct Entered<'a>(&'a AtomicBool);

impl Drop for Entered<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}
