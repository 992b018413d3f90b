//! A pool of helper threads for one searching thread.

use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

use crate::base::threads::cores;
use crate::base::threads::helper;
use crate::base::threads::job_stack::OpenJob;
use crate::base::threads::pool_state::{PoolState, Work};
use crate::base::threads::preemption::{self, Observation, time_away};
use crate::base::threads::sleep::Sleep;
use crate::base::threads::tuning::{CALLER_INTERVAL, CALLER_LOST_MIN};

/// The helper threads of one searching thread.
#[derive(Debug)]
pub struct Pool {
    state: Arc<PoolState>,
    helpers: Vec<JoinHandle<()>>,
    /// When the searching thread was observed last. Only this thread uses it.
    observed: Mutex<Option<Observation>>,
}

impl Pool {
    /// Starts helpers. Returns when all have started, so that none allocates memory later.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn new(helper_count: NonZeroUsize) -> std::io::Result<Self> {
        let helper_count = helper_count.get();
        let state = Arc::new(PoolState {
            sleeps: (0..helper_count).map(|_| Sleep::default()).collect(),
            ..PoolState::default()
        });
        let mut pool =
            Self { state, helpers: Vec::with_capacity(helper_count), observed: Mutex::new(None) };
        for index in 0..helper_count {
            let state = Arc::clone(&pool.state);
            let name = format!("planner {}", index + 1);
            let helper = Builder::new().name(name).spawn(move || helper::serve(&state, index))?;
            pool.helpers.push(helper);
        }
        while pool.state.started.load(Ordering::SeqCst) < helper_count {
            std::thread::yield_now();
        }
        Ok(pool)
    }

    /// Number of threads that share work at this moment, the searching one included.
    pub fn attending(&self) -> usize {
        1 + self.state.attending.load(Ordering::Relaxed)
    }

    /// Runs a search on the calling thread. Within it, this thread may offer items. If another
    /// thread runs a search with this pool, the calling thread works alone.
    pub fn run<T>(&self, search: impl FnOnce() -> T) -> T {
        let thread = &self.state.search.thread;
        let is_first =
            thread.compare_exchange(0, thread_number(), Ordering::SeqCst, Ordering::SeqCst).is_ok();
        let _end = is_first.then_some(SearchEnd(thread));
        if is_first {
            *self.observed() = Some(Observation::of_this_thread());
            self.state.search.core.store(cores::current(), Ordering::Relaxed);
        }
        search()
    }

    /// Offers items to the helpers, runs `first`, then the items that no helper has claimed, and
    /// waits until all have ended.
    ///
    /// # Panics
    /// `first` or an item panics.
    pub fn offer<A>(
        &self,
        count: usize,
        run: &(dyn Fn(usize) + Sync),
        first: impl FnOnce() -> A,
    ) -> A {
        let work = Work { run, panic: Mutex::new(None) };
        let Some(job) = self.open(&work, count) else {
            let made = first();
            (0..count).for_each(run);
            return made;
        };
        let made = first();
        while let Some(item) = job.claim() {
            run(item);
        }
        drop(job);
        if let Some(panic) = work.panic.into_inner().unwrap_or_else(PoisonError::into_inner) {
            resume_unwind(panic);
        }
        made
    }

    /// Opens a job and wakes the helpers; `None` where the calling thread works alone.
    fn open<'a>(&'a self, work: &'a Work<'_>, count: usize) -> Option<OpenJob<'a, AtomicU64>> {
        if !self.is_search() || !self.has_help() {
            return None;
        }
        let place = std::ptr::from_ref(work).expose_provenance() as u64;
        let job = self.state.jobs.open(place, count)?;
        for (sleep, helper) in self.state.sleeps.iter().zip(&self.helpers) {
            sleep.wake(|| helper.thread().unpark());
        }
        Some(job)
    }

    /// Whether the calling thread is the searching one.
    fn is_search(&self) -> bool {
        self.state.search.thread.load(Ordering::Relaxed) == thread_number()
    }

    /// Whether a helper can be offered items. Sends all away where this thread was preempted: a
    /// helper may have taken the core to which the system would move it.
    fn has_help(&self) -> bool {
        let search = &self.state.search;
        let core = cores::current();
        if search.core.load(Ordering::Relaxed) != core {
            search.core.store(core, Ordering::Relaxed);
        }
        let mut observed = self.observed();
        let is_due = observed.is_none_or(|at| preemption::now() - at.time >= CALLER_INTERVAL);
        if is_due {
            let later = Observation::of_this_thread();
            let lost = observed.map_or(0, |before| before.lost_until(&later));
            *observed = Some(later);
            if lost >= CALLER_LOST_MIN {
                search.away_until.store(later.time + time_away(lost), Ordering::Relaxed);
                return false;
            }
        }
        self.state.has_help()
    }

    fn observed(&self) -> std::sync::MutexGuard<'_, Option<Observation>> {
        self.observed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.state.is_over.store(true, Ordering::SeqCst);
        for helper in self.helpers.drain(..) {
            helper.thread().unpark();
            // A helper catches the panics of items, and has none of its own to pass on.
            let _ = helper.join();
        }
    }
}

/// Ends the search of a thread when it is dropped, also by a panic.
struct SearchEnd<'a>(&'a AtomicUsize);

impl Drop for SearchEnd<'_> {
    fn drop(&mut self) {
        self.0.store(0, Ordering::SeqCst);
    }
}

/// A number of the calling thread that no other living thread has; not 0.
fn thread_number() -> usize {
    thread_local!(static PLACE: u8 = const { 0 });
    PLACE.with(|place| std::ptr::from_ref(place).addr())
}
