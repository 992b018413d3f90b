//! Threads with nothing to do: they look for work for a while, and then sleep until a bell.
//!
//! Rayon's own threads fall asleep after some 15 us, and waking one takes 50 us and more where
//! cores are virtual: longer than most of what there is to share.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::Yield;

/// How often a thread without work looks again before it sleeps: some 2 ms, longer than most of
/// what cannot be shared.
const POLLS_MAX: u32 = 16384;

/// Where the threads of a pool sleep, while one of them works and hands out what it can.
#[derive(Debug)]
pub struct IdleThreads {
    /// By thread: whether it is up the stack already, as the one that works or as one that looks
    /// for work.
    is_entered: Vec<AtomicBool>,
    is_over: AtomicBool,
    asleep: AtomicUsize,
    /// How often the bell was rung for somebody.
    wake_count: Mutex<u64>,
    wake_signal: Condvar,
}

impl IdleThreads {
    /// For so many threads.
    pub fn new(threads: usize) -> Self {
        Self {
            is_entered: (0..threads).map(|_| AtomicBool::new(false)).collect(),
            is_over: AtomicBool::new(false),
            asleep: AtomicUsize::new(0),
            wake_count: Mutex::new(0),
            wake_signal: Condvar::new(),
        }
    }

    /// Works, while the pool's other threads look for what is handed out. To be called inside the
    /// pool.
    pub fn run_with_idle<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.is_over.store(false, Ordering::SeqCst);
        let work = || {
            let _entered = self.enter();
            let _stop = StopGuard(self);
            work()
        };
        self.with_others(self.is_entered.len() - 1, work)
    }

    /// Wakes whoever sleeps: to be called once there is something to do.
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

    /// Does what there is to do until all is over. A thread that waits for another one's work takes
    /// up what it finds, this too: it has no time for it.
    fn poll_for_work(&self) {
        let Some(_entered) = self.enter() else { return };
        while !self.is_over.load(Ordering::SeqCst) {
            if !poll(POLLS_MAX, || self.is_over.load(Ordering::Relaxed)) {
                self.sleep();
            }
        }
    }

    fn sleep(&self) {
        let known = *self.wake_count.lock().unwrap_or_else(PoisonError::into_inner);
        self.asleep.fetch_add(1, Ordering::SeqCst);
        fence(Ordering::SeqCst);
        // What was handed out before anybody was asleep rang no bell.
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

    /// Notes that this thread is here; `None` where it was before.
    fn enter(&self) -> Option<Entered<'_>> {
        let is_entered = &self.is_entered[rayon::current_thread_index()?];
        (!is_entered.swap(true, Ordering::Relaxed)).then_some(Entered(is_entered))
    }
}

/// Looks for something to do, and does it, so often or until something `is_done`; answers whether
/// there was any, or it is.
pub fn poll(polls_max: u32, is_done: impl Fn() -> bool) -> bool {
    for _ in 0..polls_max {
        if is_done() || rayon::yield_now() == Some(Yield::Executed) {
            return true;
        }
        std::hint::spin_loop();
    }
    false
}

/// Ends the others' search for work, however the work ends.
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
