//! A helper thread: it claims items, polls for more, and sleeps.
//!
//! It keeps off the core of the searching thread. It yields its core between items, so that a
//! thread that also wants this core gets it there and not in the middle of an item, for which the
//! searching thread would have to wait. Where it was preempted in an item, it stays away.

use std::sync::atomic::Ordering;

use crate::base::threads::cores::{self, CoreSet};
use crate::base::threads::job_stack::Claim;
use crate::base::threads::pool_state::{PoolState, Work};
use crate::base::threads::preemption::{self, Observation, park_until, time_away};
use crate::base::threads::tuning::{
    HELPER_LOST_MIN, POLLING_TIME, POLLING_TIME_WITHOUT_SEARCH, YIELD_INTERVAL,
};

/// Runs items until the pool is dropped.
pub fn serve(state: &PoolState, index: usize) {
    let observed = Observation::of_this_thread();
    let mut helper = Helper {
        state,
        index,
        cores: CoreSet::of_this_thread(),
        observed,
        active_at: observed.time,
    };
    helper.attend();
    state.started.fetch_add(1, Ordering::SeqCst);
    while !helper.is_over() {
        helper.advance();
    }
}

struct Helper<'a> {
    state: &'a PoolState,
    index: usize,
    /// The cores that the process may use.
    cores: Option<CoreSet>,
    /// When this thread began to run, or yielded last.
    observed: Observation,
    /// When it claimed its last item, or woke.
    active_at: u64,
}

impl Helper<'_> {
    /// Runs an item, or polls once.
    fn advance(&mut self) {
        let time = preemption::now();
        let away_until = self.state.search.away_until.load(Ordering::Relaxed);
        if time < away_until {
            return self.stay_away(away_until);
        }
        if time - self.observed.time >= YIELD_INTERVAL {
            return self.yield_core();
        }
        self.leave_core_of_search();
        if let Some(claim) = self.state.jobs.claim_as_helper() {
            self.active_at = time;
            self.run(claim);
        } else if time - self.active_at >= self.polling_time() {
            self.sleep();
        } else {
            std::hint::spin_loop();
        }
    }

    fn run(&self, claim: Claim) {
        let work = std::ptr::with_exposed_provenance::<Work<'_>>(claim.work as usize);
        // SAFETY: the opening thread named its work, which is shared with this thread (`Sync`), and
        // keeps it until the claimed item has ended.
        unsafe { &*work }.run(claim.item);
        self.state.jobs.finish(claim);
    }

    /// Leaves the core to a thread that wants it, and stays away if one has had it already.
    fn yield_core(&mut self) {
        let before = Observation::of_this_thread();
        let lost = self.observed.lost_until(&before);
        if lost >= HELPER_LOST_MIN {
            return self.stay_away(before.time + time_away(lost));
        }
        self.withdraw();
        std::thread::yield_now();
        let active_at = self.active_at;
        self.attend();
        self.active_at = active_at;
    }

    fn stay_away(&mut self, until: u64) {
        self.withdraw();
        while !self.is_over() && preemption::now() < until {
            park_until(until);
        }
        self.attend();
    }

    fn sleep(&mut self) {
        let has_work = || self.is_over() || self.state.jobs.has_items();
        self.withdraw();
        self.state.sleeps[self.index].sleep(has_work, std::thread::park);
        self.attend();
    }

    /// Counts as attending, from this moment.
    fn attend(&mut self) {
        self.state.attending.fetch_add(1, Ordering::Relaxed);
        self.observed = Observation::of_this_thread();
        self.active_at = self.observed.time;
    }

    fn withdraw(&self) {
        self.state.attending.fetch_sub(1, Ordering::Relaxed);
    }

    /// Moves to another core where the searching thread is on this one.
    fn leave_core_of_search(&self) {
        let core = self.state.search.core.load(Ordering::Relaxed);
        if self.is_search()
            && core == cores::current()
            && let Some(cores) = &self.cores
        {
            cores.pin_except(core);
        }
    }

    fn polling_time(&self) -> u64 {
        if self.is_search() { POLLING_TIME } else { POLLING_TIME_WITHOUT_SEARCH }
    }

    fn is_search(&self) -> bool {
        self.state.search.thread.load(Ordering::Relaxed) != 0
    }

    fn is_over(&self) -> bool {
        self.state.is_over.load(Ordering::SeqCst)
    }
}
