//! The command's only clock. Time is reported and paces the display; no plan depends on it.

use std::time::Instant;

/// Measures elapsed time.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    #[allow(
        clippy::disallowed_methods,
        reason = "the command may time; the crates of the search may not"
    )]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// The machine's monotonic clock, ns: the same for all processes until the machine is restarted.
pub fn monotonic_nanos() -> u64 {
    let time = time_of(libc::CLOCK_MONOTONIC);
    u64::try_from(i128::from(time.tv_sec) * 1_000_000_000 + i128::from(time.tv_nsec)).unwrap_or(0)
}

/// Time that this process's threads have spent on the processor, s; 0 where the system does not
/// say. Unlike [`Stopwatch`] it does not run while others have the processor.
pub fn processor_seconds() -> f64 {
    let time = time_of(libc::CLOCK_PROCESS_CPUTIME_ID);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// The time of one of the system's clocks; 0 where the system does not have it.
fn time_of(clock: libc::clockid_t) -> libc::timespec {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec of ours that outlives the call.
    let answer = unsafe { libc::clock_gettime(clock, &raw mut time) };
    if answer == 0 { time } else { libc::timespec { tv_sec: 0, tv_nsec: 0 } }
}
