//! The state that a searching thread and its helpers use together.

use std::any::Any;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::base::threads::job_stack::JobStack;
use crate::base::threads::sleep::Sleep;

/// The state that the threads of a pool use together.
#[derive(Debug, Default)]
pub struct PoolState {
    /// The jobs.
    pub jobs: JobStack<AtomicU64>,
    /// The searching thread.
    pub search: SearchingThread,
    /// Whether the helpers must end.
    pub is_over: AtomicBool,
    /// Helpers that claim items or poll for them at this moment.
    pub attending: AtomicUsize,
    /// Helpers that have started.
    pub started: AtomicUsize,
    /// By helper: whether it sleeps.
    pub sleeps: Box<[Sleep<AtomicU64>]>,
}

/// Data of the searching thread for the helpers.
#[derive(Debug, Default)]
#[repr(align(128))]
pub struct SearchingThread {
    /// Its number; 0 while no search runs.
    pub thread: AtomicUsize,
    /// The core on which it was seen last.
    pub core: AtomicU64,
    /// The time until which helpers stay away because it was preempted, ns.
    pub away_until: AtomicU64,
}

/// The work of a job. It is on the opening thread's stack while the job is open.
pub struct Work<'a> {
    /// Runs an item.
    pub run: &'a (dyn Fn(usize) + Sync),
    /// The panic of an item on a helper thread.
    pub panic: Mutex<Option<Box<dyn Any + Send>>>,
}

impl PoolState {
    /// Whether a helper attends, or would when it is woken.
    pub fn has_help(&self) -> bool {
        self.attending.load(Ordering::Relaxed) > 0 || self.sleeps.iter().any(Sleep::is_asleep)
    }
}

impl Work<'_> {
    /// Runs an item on a helper thread. Keeps a panic for the opening thread.
    pub fn run(&self, item: usize) {
        let run = std::panic::AssertUnwindSafe(|| (self.run)(item));
        if let Err(panic) = std::panic::catch_unwind(run) {
            *self.panic.lock().unwrap_or_else(PoisonError::into_inner) = Some(panic);
        }
    }
}
