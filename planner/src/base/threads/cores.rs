//! The cores of the search: how many it may use, and who runs on which.

use std::num::NonZeroUsize;

/// Cores that a set can hold.
const CORES_MAX: u64 = libc::CPU_SETSIZE as u64;

/// The core that the calling thread runs on; an unused number where the system does not say.
pub fn current() -> u64 {
    // SAFETY: the call has no arguments and touches no memory of ours.
    u64::try_from(unsafe { libc::sched_getcpu() }).unwrap_or(u64::MAX)
}

/// The number of cores that this process may use: those of its affinity and of its control group.
pub fn available() -> NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// The cores that a thread may run on.
#[derive(Clone, Copy)]
pub struct CoreSet(libc::cpu_set_t);

impl CoreSet {
    /// The cores of the calling thread; `None` where there are more than the type can hold.
    pub fn of_this_thread() -> Option<Self> {
        // SAFETY: a set of zero bytes is the empty set.
        let mut set: libc::cpu_set_t = unsafe { std::mem::zeroed() };
        // SAFETY: the pointer is to a set of this size.
        let answer =
            unsafe { libc::sched_getaffinity(0, size_of::<libc::cpu_set_t>(), &raw mut set) };
        (answer == 0).then_some(Self(set))
    }

    /// Keeps the calling thread off a core, if the set has another one.
    pub fn pin_except(&self, core: u64) {
        if core >= CORES_MAX {
            return;
        }
        let mut set = *self;
        // SAFETY: the functions change a bit of the set and count its bits.
        let is_left = unsafe {
            libc::CPU_CLR(core as usize, &mut set.0);
            libc::CPU_COUNT(&set.0) > 0
        };
        if is_left {
            set.pin();
        }
    }

    /// Keeps the calling thread on the cores of the set. If that fails, it stays where it is.
    fn pin(&self) {
        // SAFETY: the pointer is to a set of this size.
        unsafe { libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const self.0) };
    }
}

impl std::fmt::Debug for CoreSet {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("CoreSet").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of the cores of a set.
    fn numbers(cores: &CoreSet) -> Vec<u64> {
        // SAFETY: the function reads a bit.
        let has = |core: &u64| unsafe { libc::CPU_ISSET(*core as usize, &cores.0) };
        (0..CORES_MAX).filter(has).collect()
    }

    #[test]
    fn a_thread_is_kept_off_a_core_unless_it_has_no_other() {
        let before = CoreSet::of_this_thread().unwrap();
        let all = numbers(&before);
        for &core in &all {
            before.pin_except(core);
            let left: Vec<u64> = all.iter().copied().filter(|&other| other != core).collect();
            let expected = if left.is_empty() { &all } else { &left };
            assert_eq!(&numbers(&CoreSet::of_this_thread().unwrap()), expected);
            before.pin();
        }
    }
}
