//! Splits Rust source into code, comments and string literals.

/// What a piece of source is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Code outside comments and string literals.
    Code,
    /// A line, block or doc comment.
    Comment,
    /// A string literal with its quotes.
    Literal,
}

/// A piece of one line.
#[derive(Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// What it is.
    pub kind: Kind,
    /// Its line, from 1.
    pub line: usize,
    /// Its first column in characters, from 0.
    pub column: usize,
    /// Its text, without the line break.
    pub text: &'a str,
}

/// The pieces of a source in order. A comment or literal of several lines is one piece per line.
pub fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut found = vec![];
    let (mut at, mut line, mut column) = (0, 1, 0);
    while at < text.len() {
        let (kind, end) = next_piece(text, at);
        for part in text[at..end].split_inclusive('\n') {
            let shown = part.trim_end_matches(['\n', '\r']);
            if !shown.is_empty() {
                found.push(Piece { kind, line, column, text: shown });
            }
            column += part.chars().count();
            if part.ends_with('\n') {
                (line, column) = (line + 1, 0);
            }
        }
        at = end;
    }
    found
}

/// The kind of the piece that begins at a byte, and the byte after its end.
fn next_piece(text: &str, at: usize) -> (Kind, usize) {
    let rest = &text[at..];
    if rest.starts_with("//") {
        return (Kind::Comment, at + rest.find('\n').unwrap_or(rest.len()));
    }
    if rest.starts_with("/*") {
        return (Kind::Comment, at + block_comment_length(rest));
    }
    if let Some(length) = literal_length(rest) {
        return (Kind::Literal, at + length);
    }
    (Kind::Code, at + code_length(rest))
}

fn block_comment_length(rest: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        if rest[at..].starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest[at..].starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += rest[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    rest.len()
}

/// The length of the string literal at the beginning, if there is one.
fn literal_length(rest: &str) -> Option<usize> {
    let after_prefix = rest.trim_start_matches(['b', 'c', 'r']);
    let prefix = &rest[..rest.len() - after_prefix.len()];
    let is_raw = prefix.ends_with('r');
    if prefix.len() > 2 || (prefix.len() == 2 && !is_raw) {
        return None;
    }
    let hashes = after_prefix.len() - after_prefix.trim_start_matches('#').len();
    let body = after_prefix[hashes..].strip_prefix('"')?;
    if hashes > 0 && !is_raw {
        return None;
    }
    let begin = prefix.len() + hashes + 1;
    if is_raw {
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(body.find(&end).map_or(rest.len(), |at| begin + at + end.len()));
    }
    let mut is_escaped = false;
    for (at, character) in body.char_indices() {
        match character {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return Some(begin + at + 1),
            _ => {}
        }
    }
    Some(rest.len())
}

/// The length of the code up to the next comment or string literal, one byte at least.
fn code_length(rest: &str) -> usize {
    let mut at = 0;
    while at < rest.len() {
        let here = &rest[at..];
        if at > 0 && (here.starts_with("//") || here.starts_with("/*")) {
            return at;
        }
        if at > 0 && literal_length(here).is_some() {
            return at;
        }
        at += token_length(here);
    }
    rest.len()
}

/// The length of the identifier, character literal or single character at the beginning.
fn token_length(rest: &str) -> usize {
    let mut characters = rest.chars();
    let first = characters.next().unwrap_or(' ');
    if first.is_alphabetic() || first == '_' {
        return rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    }
    if first == '\'' {
        let second = characters.next().unwrap_or(' ');
        if second == '\\' {
            return 3 + rest[3..].find('\'').map_or(0, |end| end + 1);
        }
        if characters.next() == Some('\'') {
            return 2 + second.len_utf8();
        }
    }
    first.len_utf8()
}
