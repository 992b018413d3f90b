//! The system's limits of this process.

/// Open files that a walk needs, with a margin.
pub const OPEN_FILES_MIN: u64 = 256;
/// Fewest open files with which a process of a walk can begin.
const OPEN_FILES_LEAST: u64 = 36;
/// Open files that a process asks for where it may: many readers may subscribe to an instance.
const OPEN_FILES_WANTED: u64 = 1024;

/// Size that a file may have to hold the largest segment of a walk, KiB: twice what it needs.
pub const FILE_KIB_MIN: u64 = 32_768;

/// Stack of the main thread that a process needs, KiB, with a margin: twice what it uses.
pub const STACK_KIB_MIN: u64 = 4096;
/// Stack that a process asks for where it may, KiB: the usual limit.
pub const STACK_KIB_WANTED: u64 = 8192;

/// The soft limit; `None` if there is none.
pub fn soft_limit(resource: libc::__rlimit_resource_t) -> Option<u64> {
    Some(limits(resource).rlim_cur).filter(|limit| *limit != libc::RLIM_INFINITY)
}

fn limits(resource: libc::__rlimit_resource_t) -> libc::rlimit {
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` outlives the call. It fails only for unknown resources.
    unsafe { libc::getrlimit(resource, &raw mut limit) };
    limit
}

/// Raises the number of files that this process may open, as far as it is permitted and of use.
pub fn raise_open_files() {
    let mut limit = limits(libc::RLIMIT_NOFILE);
    let wanted = OPEN_FILES_WANTED.min(limit.rlim_max);
    if limit.rlim_cur < wanted {
        limit.rlim_cur = wanted;
        // SAFETY: `limit` outlives the call. A failure leaves the limit as it is.
        unsafe { libc::setrlimit(libc::RLIMIT_NOFILE, &raw const limit) };
    }
}

/// Raises the limit of the main thread's stack, which grows as it is used, as far as it is
/// permitted and of use.
pub fn raise_stack() {
    let mut limit = limits(libc::RLIMIT_STACK);
    let wanted = (1024 * STACK_KIB_WANTED).min(limit.rlim_max);
    if limit.rlim_cur < wanted {
        limit.rlim_cur = wanted;
        // SAFETY: `limit` outlives the call. A failure leaves the limit as it is.
        unsafe { libc::setrlimit(libc::RLIMIT_STACK, &raw const limit) };
    }
}

/// The limit of the main thread's stack, KiB, if it is too low.
pub fn too_small_stack() -> Option<u64> {
    soft_limit(libc::RLIMIT_STACK).map(|bytes| bytes / 1024).filter(|kib| *kib < STACK_KIB_MIN)
}

/// The limit of a file's size, KiB, if it is too low for shared memory.
pub fn too_small_files() -> Option<u64> {
    soft_limit(libc::RLIMIT_FSIZE).map(|bytes| bytes / 1024).filter(|kib| *kib < FILE_KIB_MIN)
}

/// The number of files that this process may open, if it is too low for shared memory.
pub fn too_few_open_files() -> Option<u64> {
    soft_limit(libc::RLIMIT_NOFILE).filter(|files| *files < OPEN_FILES_LEAST)
}

/// Lets the owner of new files and folders use them. A stricter mask would lock this process out of
/// its own shared memory.
pub fn permit_owner() {
    // SAFETY: umask cannot fail and touches no memory.
    unsafe {
        let mask = libc::umask(0o077);
        libc::umask(mask & 0o077);
    }
}
