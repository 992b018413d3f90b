//! The stack on which a command runs.

use crate::system::limits::{STACK_KIB_WANTED, too_small_stack};

/// Runs the command on the main thread's stack, or, where the system limits that too much, on
/// another thread, whose stack the limit does not concern.
///
/// # Errors
/// The limit of the main thread's stack, KiB, if no other thread can be made.
///
/// # Panics
/// The command panics.
pub fn run(command: fn() -> u8) -> Result<u8, u64> {
    let Some(kib) = too_small_stack() else { return Ok(command()) };
    let bytes = usize::try_from(1024 * STACK_KIB_WANTED).unwrap_or(usize::MAX);
    let thread = std::thread::Builder::new().stack_size(bytes).spawn(command);
    let ended = thread.map_err(|_| kib)?.join();
    Ok(ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}
