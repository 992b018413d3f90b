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

/// Prints an error as one line, and each further one that it holds as one more.
pub fn print_error(error: &dyn std::fmt::Display) {
    for text in error.to_string().split("\nerror: ") {
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        print_note(&format!("error: {line}"));
    }
}

/// The text with every character that a terminal obeys, but line feeds and tabs, as an escape. In
/// JSON, which holds such characters in strings alone, the escape is JSON's.
fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let is_json = text.starts_with(['{', '[']);
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        if !is_obeyed(letter) {
            escaped.push(letter);
        } else if is_json {
            escaped.push_str(&format!("\\u{:04x}", u32::from(letter)));
        } else {
            escaped.extend(letter.escape_unicode());
        }
    }
    Cow::Owned(escaped)
}

/// Whether a terminal obeys a character: control characters, ends of lines and paragraphs, and
/// those that change the direction of writing.
fn is_obeyed(letter: char) -> bool {
    match letter {
        '\n' | '\t' => false,
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        _ => letter.is_control(),
    }
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
        assert_eq!(printable("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(printable("{\"a\": \"\u{9b}\"}"), "{\"a\": \"\\u009b\"}");
    }
}
