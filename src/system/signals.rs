//! Signals that ask the process to end. They are recorded here and checked between two pieces of
//! work.

use std::sync::atomic::{AtomicI32, Ordering};

use libc::c_int;

static RAISED: AtomicI32 = AtomicI32::new(0);

/// Notes SIGINT, SIGTERM and SIGHUP from now on. A second SIGINT ends the process at once; of the
/// others more may come, as the kernel sends one for each thread of a dying parent.
pub fn install() {
    for (signal, flags) in
        [(libc::SIGINT, libc::SA_RESETHAND), (libc::SIGTERM, 0), (libc::SIGHUP, 0)]
    {
        // SAFETY: an all-zero sigaction is a valid one.
        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        action.sa_sigaction = note as extern "C" fn(c_int) as libc::sighandler_t;
        action.sa_flags = libc::SA_RESTART | flags;
        // SAFETY: `note` only stores an atomic, which is allowed in a handler. A failure leaves the
        // default action in place.
        unsafe { libc::sigaction(signal, &action, std::ptr::null_mut()) };
    }
}

/// The signal that asked this process to end, if one did.
pub fn raised() -> Option<i32> {
    Some(RAISED.load(Ordering::Relaxed)).filter(|signal| *signal != 0)
}

/// Asks the kernel to send SIGTERM to this process when the thread that started it ends, however
/// that comes about.
pub fn end_with_parent() {
    // SAFETY: prctl with these arguments touches no memory. A failure only means that an orphan
    // ends later.
    unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGTERM) };
}

/// Asks a child process that was not yet waited for to end.
pub fn ask_to_end(child: &std::process::Child) {
    if let Ok(pid) = libc::pid_t::try_from(child.id()) {
        // SAFETY: kill touches no memory; the child was not waited for, so the id is still its own.
        unsafe { libc::kill(pid, libc::SIGTERM) };
    }
}

extern "C" fn note(signal: c_int) {
    RAISED.store(signal, Ordering::Relaxed);
}
