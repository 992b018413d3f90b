//! Signals that ask the process to end.
//!
//! Such a signal ends the process at once, with one line that names its activity, unless it is
//! deferred ([`defer`]). Then it is recorded here and checked between two pieces of work. A signal
//! that the parent process ignores stays ignored, as under `nohup`.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU8, AtomicUsize, Ordering};

use libc::c_int;

use crate::system::fixed_text::FixedText;

static RAISED: AtomicI32 = AtomicI32::new(0);
static DEFERRALS: AtomicUsize = AtomicUsize::new(0);
static EXPOSURES: AtomicUsize = AtomicUsize::new(0);
static ACTIVITY: AtomicU8 = AtomicU8::new(0);
static IS_SILENT: AtomicBool = AtomicBool::new(false);
static HAS_TERMINAL: AtomicBool = AtomicBool::new(false);

/// What the process does outside of all deferrals, for the line that a signal leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Nothing that takes long.
    Other,
    /// It reads its input files.
    Reading,
    /// It prepares the robot.
    Preparing,
    /// It draws a picture.
    Drawing,
    /// It writes to a pipe or a device.
    Writing,
}

impl Activity {
    const DESCRIPTIONS: [&'static str; 5] = [
        "",
        " while reading its files",
        " while preparing the robot",
        " while drawing the picture",
        " while writing its output",
    ];
}

/// Sets the activity of the process.
pub fn set_activity(activity: Activity) {
    ACTIVITY.store(activity as u8, Ordering::Relaxed);
}

/// Takes SIGINT, SIGTERM and SIGHUP from now on, and turns SIGXFSZ into an error of the write. A
/// second SIGINT ends the process at once; of the others more may come, as the kernel sends one for
/// each thread of a dying parent. The process of a role takes SIGTERM in any case: its supervisor
/// ends it so, and reports it.
pub fn install(is_role: bool) {
    IS_SILENT.store(is_role, Ordering::Relaxed);
    HAS_TERMINAL.store(std::io::stderr().is_terminal(), Ordering::Relaxed);
    for (signal, flags) in
        [(libc::SIGINT, libc::SA_RESETHAND), (libc::SIGTERM, 0), (libc::SIGHUP, 0)]
    {
        if !is_ignored(signal) || (is_role && signal == libc::SIGTERM) {
            set_action(signal, note as extern "C" fn(c_int) as libc::sighandler_t, flags);
        }
    }
    set_action(libc::SIGXFSZ, libc::SIG_IGN, 0);
}

fn is_ignored(signal: c_int) -> bool {
    // SAFETY: an all-zero sigaction is a valid one.
    let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
    // SAFETY: `action` outlives the call, which only reads the action in place.
    let answer = unsafe { libc::sigaction(signal, std::ptr::null(), &raw mut action) };
    answer == 0 && action.sa_sigaction == libc::SIG_IGN
}

fn set_action(signal: c_int, handler: libc::sighandler_t, flags: c_int) {
    // SAFETY: an all-zero sigaction is a valid one.
    let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
    action.sa_sigaction = handler;
    action.sa_flags = libc::SA_RESTART | flags;
    // SAFETY: the handler is `note`, which only does what a handler may, or SIG_IGN. A failure
    // leaves the default action in place.
    unsafe { libc::sigaction(signal, &raw const action, std::ptr::null_mut()) };
}

/// Counts in one of the counters while it exists.
#[derive(Debug)]
#[must_use]
pub struct Counted(&'static AtomicUsize);

impl Counted {
    fn new(counter: &'static AtomicUsize) -> Self {
        counter.fetch_add(1, Ordering::SeqCst);
        Self(counter)
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Records signals, which do not end the process, until the result is dropped. The holder checks
/// [`raised`].
pub fn defer() -> Counted {
    Counted::new(&DEFERRALS)
}

/// Lets signals end the process until the result is dropped, although they are deferred: the
/// process waits for another program, which may never come.
pub fn expose() -> Counted {
    Counted::new(&EXPOSURES)
}

/// The signal that asked this process to end, if one did.
pub fn raised() -> Option<i32> {
    Some(RAISED.load(Ordering::Relaxed)).filter(|signal| *signal != 0)
}

/// Takes the signal that asked this process to end, which has done what it was asked to.
pub fn take() -> Option<i32> {
    Some(RAISED.swap(0, Ordering::Relaxed)).filter(|signal| *signal != 0)
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

/// A handler: atomics, `write` and `_exit` alone.
extern "C" fn note(signal: c_int) {
    RAISED.store(signal, Ordering::Relaxed);
    if DEFERRALS.load(Ordering::SeqCst) > 0 && EXPOSURES.load(Ordering::SeqCst) == 0 {
        return;
    }
    if !IS_SILENT.load(Ordering::Relaxed) {
        let activity = usize::from(ACTIVITY.load(Ordering::Relaxed));
        let activity = Activity::DESCRIPTIONS.get(activity).copied().unwrap_or_default();
        // A bar may stand in the terminal's line.
        let clear = if HAS_TERMINAL.load(Ordering::Relaxed) { "\r\u{1b}[2K" } else { "" };
        let mut line = FixedText::<128>::default();
        line.push(format_args!("{clear}error: ended by signal {signal}{activity}\n"));
        line.write_to(libc::STDERR_FILENO);
    }
    // SAFETY: it ends the process, and is allowed in a handler.
    unsafe { libc::_exit(128 + signal) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_activity_has_its_description() {
        let descriptions = Activity::DESCRIPTIONS;
        assert!(descriptions[Activity::Other as usize].is_empty());
        assert!(descriptions[Activity::Reading as usize].contains("reading"));
        assert!(descriptions[Activity::Preparing as usize].contains("preparing"));
        assert!(descriptions[Activity::Drawing as usize].contains("drawing"));
        assert!(descriptions[Activity::Writing as usize].contains("writing"));
    }
}
