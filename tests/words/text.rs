//! Splits a file into lines of words: `way_back`, `WayBack`, "way-back" and "way back" are two.

use crate::lexer::{self, pieces};
use crate::source::Source;

/// How a word follows the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Join {
    /// It begins a name or follows something else than a space.
    Break,
    /// One space or hyphen stands between them.
    Space,
    /// Both are parts of one name.
    Name,
}

/// A part of a name, or a word of prose.
#[derive(Debug, PartialEq, Eq)]
pub struct Part {
    /// In lower case.
    pub text: String,
    /// How it follows the one before it.
    pub join: Join,
    /// Whether it stands in code: in a source, between backticks, or in a name of several parts.
    pub is_code: bool,
}

/// A line, or the piece of one that is code, comment or literal.
pub struct Line {
    /// Its number, from 1.
    pub number: usize,
    /// Its words.
    pub parts: Vec<Part>,
    /// Its text where it is Rust code.
    pub code: Option<String>,
}

/// The lines of a file.
pub fn lines(source: &Source) -> Vec<Line> {
    if source.path.ends_with(".rs") {
        let line = |piece: &lexer::Piece<'_>| {
            let is_code = piece.kind == lexer::Kind::Code;
            let code = is_code.then(|| piece.text.to_owned());
            Line { number: piece.line, parts: parts(piece.text, is_code), code }
        };
        return pieces(&source.text).iter().map(line).collect();
    }
    let is_changelog = source.path == "CHANGELOG.md";
    let kept = source.text.lines().enumerate();
    // The changelog's tables list old names beside the new ones.
    let kept = kept.filter(|(_, line)| !(is_changelog && line.starts_with('|')));
    kept.map(|(at, line)| Line { number: at + 1, parts: parts(line, false), code: None }).collect()
}

/// The words of a text.
pub fn parts(text: &str, is_code: bool) -> Vec<Part> {
    let mut found = vec![];
    let mut is_quoted = false;
    let mut between = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        if !is_letter(first) {
            is_quoted ^= first == '`';
            between.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let end = rest.find(|c: char| !is_letter(c)).unwrap_or(rest.len());
        let names = split(&rest[..end]);
        let is_name = is_code || is_quoted || names.len() > 1;
        let is_next = !is_code && (between == " " || between == "-");
        for (at, text) in names.into_iter().enumerate() {
            let join = match at {
                0 if is_next => Join::Space,
                0 => Join::Break,
                _ => Join::Name,
            };
            found.push(Part { text, join, is_code: is_name });
        }
        between.clear();
        rest = &rest[end..];
    }
    found
}

fn is_letter(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

/// The parts of a name, in lower case.
pub fn split(name: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let characters: Vec<char> = name.chars().collect();
    for (at, &character) in characters.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| characters[before]);
        let is_hump = character.is_uppercase()
            && (before.is_some_and(|one| one.is_lowercase() || one.is_numeric())
                || before.is_some_and(char::is_uppercase)
                    && characters.get(at + 1).is_some_and(|next| next.is_lowercase()));
        if character == '_' || is_hump {
            parts.push(String::new());
        }
        if character != '_' {
            parts.last_mut().unwrap().extend(character.to_lowercase());
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}
