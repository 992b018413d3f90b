//! Output for the terminal. Results go to stdout, errors and notes to stderr; a closed pipe is no
//! error.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a result could not be printed.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a result.
pub fn print_result(text: &str) {
    let mut out = std::io::stdout().lock();
    let written = writeln!(out, "{text}").and_then(|()| out.flush());
    if written.is_err_and(|error| error.kind() != ErrorKind::BrokenPipe) {
        LOST.store(true, Ordering::Relaxed);
    }
}

/// Whether a result was lost although stdout is open, for example on a full disk.
pub fn has_lost_output() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Prints a note to stderr.
pub fn print_note(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints an error as one line.
pub fn print_error(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    print_note(&format!("error: {line}"));
}

/// Whether stderr is a terminal.
pub fn is_watched() -> bool {
    std::io::stderr().is_terminal()
}
