//! Whether a thread was preempted. The only clock of the planner: it decides which thread works,
//! never the result.

use std::time::Duration;

use crate::base::threads::tuning::{AWAY_FACTOR, AWAY_MAX};

/// Time since some fixed moment, ns.
pub fn now() -> u64 {
    read(libc::CLOCK_MONOTONIC)
}

/// Times of a thread, which show when it was without a core.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// Time of the observation, ns.
    pub time: u64,
    /// Time that the thread had run on a core, ns.
    run: u64,
}

impl Observation {
    /// Observes the calling thread.
    pub fn of_this_thread() -> Self {
        let run = read(libc::CLOCK_THREAD_CPUTIME_ID);
        Self { time: now(), run }
    }

    /// Time between two observations in which the thread was without a core, ns.
    pub fn lost_until(&self, later: &Self) -> u64 {
        (later.time - self.time).saturating_sub(later.run - self.run)
    }
}

/// Parks the calling thread until a time, ns, or until it is unparked.
pub fn park_until(time: u64) {
    std::thread::park_timeout(Duration::from_nanos(time.saturating_sub(now())));
}

/// How long helpers stay away after a preemption, ns.
pub fn time_away(lost: u64) -> u64 {
    lost.saturating_mul(AWAY_FACTOR).min(AWAY_MAX)
}

fn read(clock: libc::clockid_t) -> u64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec that outlives the call. Linux has both clocks.
    unsafe { libc::clock_gettime(clock, &raw mut time) };
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_sleeps_is_without_a_core() {
        let before = Observation::of_this_thread();
        std::thread::sleep(Duration::from_millis(20));
        let after = Observation::of_this_thread();
        assert!(before.lost_until(&after) >= 19_000_000);
    }

    #[test]
    fn the_time_away_is_bounded() {
        assert_eq!(time_away(4_000_000), 100_000_000);
        assert_eq!(time_away(u64::MAX), AWAY_MAX);
    }
}
