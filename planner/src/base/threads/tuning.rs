//! Constants of the helper threads. They change speed but no result.

/// Jobs that may be open at once: a job, and those that its items open on the same thread.
pub const JOBS_MAX: usize = 4;

/// Most items of a job; longer lists are offered in several jobs.
pub const ITEMS_MAX: usize = 4_000;

/// Time that a helper polls for items before it sleeps, ns: longer than most sequential work,
/// because waking a thread takes 50 µs.
pub const POLLING_TIME: u64 = 2_000_000;

/// Time that a helper polls for items before it sleeps while no search runs, ns.
pub const POLLING_TIME_WITHOUT_SEARCH: u64 = 100_000;

/// Time after which a helper without an item yields its core, ns. On a core that another thread
/// wants, it is mostly preempted there instead of in an item. Less than a time slice.
pub const YIELD_INTERVAL: u64 = 800_000;

/// Time between two looks at whether the searching thread was preempted, ns.
pub const CALLER_INTERVAL: u64 = 1_000_000;

/// Shortest time without the core that counts as preempted, ns: longer than an interrupt.
pub const HELPER_LOST_MIN: u64 = 60_000;

/// Shortest time without the core after which the searching thread counts as preempted, ns.
pub const CALLER_LOST_MIN: u64 = 500_000;

/// A helper stays away for this many times as long as it, or the searching thread, was preempted.
/// The time lost to waiting for a preempted helper is then at most 4 %.
pub const AWAY_FACTOR: u64 = 25;

/// Longest time that helpers stay away at once, ns.
pub const AWAY_MAX: u64 = 1_000_000_000;

/// Polls of the searching thread for the last items of helpers before it yields: about 1 ms.
pub const WAIT_POLLS_MAX: u32 = 20_000;
