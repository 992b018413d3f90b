//! Words to the person at the terminal. Results go to stdout, complaints to stderr; nobody listening is no error.

use std::io::{IsTerminal, Write};

/// Prints a result.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
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
