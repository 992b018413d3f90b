//! Threads that keep cores busy.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::report::command_error::CommandError;
use crate::system::cores;

/// Time after which a busy loop has its core, and the system has moved other threads, ms.
const SETTLING_MILLIS: u64 = 30;

/// Calls `measure` while a loop runs on each of some cores; a core may be given twice.
///
/// # Errors
/// Those of `measure`.
pub fn run_beside<T>(
    loops: &[usize],
    measure: impl FnOnce() -> Result<T, CommandError>,
) -> Result<T, CommandError> {
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for &core in loops {
            let is_over = &is_over;
            scope.spawn(move || {
                cores::pin(Some(core));
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let guard = LoopGuard(&is_over);
        std::thread::sleep(std::time::Duration::from_millis(SETTLING_MILLIS));
        let measured = measure();
        drop(guard);
        measured
    })
}

/// Ends the loops when it is dropped, also by a panic.
struct LoopGuard<'a>(&'a AtomicBool);

impl Drop for LoopGuard<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
