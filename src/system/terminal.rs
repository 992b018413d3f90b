//! Output for the terminal. Results go to stdout, errors and notes to stderr; a closed pipe is not
//! an error. Control characters, which a file's contents may hold, are printed as escapes.

use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a result could not be printed.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a result.
pub fn print_result(text: &str) {
    let mut out = std::io::stdout().lock();
    let written = writeln!(out, "{}", printable(text)).and_then(|()| out.flush());
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
    let _ = writeln!(std::io::stderr(), "{}", printable(text));
}

/// Prints an error as one line.
pub fn print_error(error: &dyn std::fmt::Display) {
    let text = error.to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    print_note(&format!("error: {line}"));
}

/// The text with every control character but line feeds and tabs as `\u{..}`.
fn printable(text: &str) -> Cow<'_, str> {
    let is_control = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
    if !text.contains(is_control) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        if is_control(letter) {
            escaped.extend(letter.escape_unicode());
        } else {
            escaped.push(letter);
        }
    }
    Cow::Owned(escaped)
}

/// Whether stderr is a terminal.
pub fn is_watched() -> bool {
    std::io::stderr().is_terminal()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(printable("a line\n\tof text"), "a line\n\tof text");
        assert_eq!(printable("\u{1b}[31mred\u{9b}"), "\\u{1b}[31mred\\u{9b}");
    }
}
