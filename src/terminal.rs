//! Words to the person at the terminal. Results go to stdout, complaints to stderr; nobody
//! listening is no error.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a result could not be printed.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a result.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    let said = writeln!(out, "{text}").and_then(|()| out.flush());
    if said.is_err_and(|error| error.kind() != ErrorKind::BrokenPipe) {
        LOST.store(true, Ordering::Relaxed);
    }
}

/// Whether a result was lost although somebody listens: its file's disk is full, say.
pub fn has_lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Prints a remark beside the result.
pub fn remark(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints an error as one line.
pub fn complain(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    remark(&format!("error: {line}"));
}

/// Whether a person watches stderr.
pub fn is_watched() -> bool {
    std::io::stderr().is_terminal()
}
