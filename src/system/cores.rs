//! Cores: their number, and the assignment of processes to them.

/// Most planner threads that the command line accepts.
pub const THREADS_MAX: i64 = 256;

/// Binds this thread, and all that it starts, to a core. Without effect where there is no such
/// core.
pub fn pin(core: Option<usize>) {
    if let Some(id) = core {
        core_affinity::set_for_current(core_affinity::CoreId { id });
    }
}

/// The cores of planner and controller, where there are two: the controller has the last one, and a
/// planner of one thread the first. A planner of more threads sees to it by itself.
pub fn cores_of_roles(threads: usize) -> (Option<usize>, Option<usize>) {
    let cores: Vec<usize> =
        core_affinity::get_core_ids().unwrap_or_default().into_iter().map(|core| core.id).collect();
    match cores[..] {
        [first, .., last] => ((threads == 1).then_some(first), Some(last)),
        _ => (None, None),
    }
}

/// Planner threads by default: two, or one where there is one core.
pub fn default_threads() -> usize {
    cores().min(2)
}

/// Cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
