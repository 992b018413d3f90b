//! Cores: their number, and the assignment of processes to them.

/// Most planner threads that the command line accepts.
pub const THREADS_MAX: u64 = 256;

/// Pins this thread and all threads that it starts to a core. No effect if the core does not exist.
pub fn pin(core: Option<usize>) {
    if let Some(id) = core {
        core_affinity::set_for_current(core_affinity::CoreId { id });
    }
}

/// The cores of planner and controller on a machine with at least two: the controller gets the
/// last, a planner with one thread the first. A planner with more threads is not pinned.
pub fn cores_of_roles(threads: usize) -> (Option<usize>, Option<usize>) {
    match usable()[..] {
        [first, .., last] => ((threads == 1).then_some(first), Some(last)),
        _ => (None, None),
    }
}

/// The cores that this process may use, in ascending order.
pub fn usable() -> Vec<usize> {
    core_affinity::get_core_ids().unwrap_or_default().into_iter().map(|core| core.id).collect()
}

/// Planner threads by default: two, or one where there is one core.
pub fn default_threads() -> usize {
    cores().min(2)
}

/// Planner threads that run where `asked` are asked for: at most one for each core.
pub fn planner_threads(asked: Option<u16>) -> usize {
    asked.map_or_else(default_threads, |asked| usize::from(asked).min(cores()))
}

/// Number of cores that this process may use, by its affinity and its control group.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
