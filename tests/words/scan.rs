//! Looks for retired words.

use std::collections::BTreeMap;

use regex::Regex;

use crate::source::Source;
use crate::table::{Kind, Word};
use crate::text::{Join, Line, Part, lines, parts};

/// The folders of the crates' sources, where a file is a module.
const SOURCES: [&str; 4] = ["src/", "planner/src/", "controller-sim/src/", "shared-types/src/"];

/// A retired word, taken apart.
struct Pattern<'t> {
    word: &'t Word,
    retired: &'t str,
    parts: Vec<String>,
    allowed: Vec<Vec<String>>,
    definition: Option<Regex>,
}

impl<'t> Pattern<'t> {
    fn new(word: &'t Word, retired: &'t str) -> Pattern<'t> {
        let split = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let parts = split(retired);
        let snake = parts.join("_");
        let camel: String = parts.iter().map(|part| capitalized(part)).collect();
        let definition = match word.kind {
            Kind::Types => Some(format!(r"\b(?:struct|enum|union|trait|type)\s+{camel}\b")),
            Kind::Functions => Some(format!(r"\bfn\s+{snake}\b")),
            Kind::Modules => Some(format!(r"\bmod\s+{snake}\b")),
            _ => None,
        };
        let definition = definition.map(|text| Regex::new(&text).unwrap());
        let allowed = word.allowed.iter().map(|text| split(text)).collect();
        Pattern { word, retired, parts, allowed, definition }
    }

    fn is_in(&self, line: &Line) -> bool {
        if let Some(definition) = &self.definition {
            return line.code.as_ref().is_some_and(|code| definition.is_match(code));
        }
        (0..line.parts.len()).any(|at| {
            fits(&line.parts, at, &self.parts)
                && self.is_of_kind(&line.parts, at)
                && !self.is_allowed(&line.parts, at)
        })
    }

    /// Whether the words at a place stand in a name as the kind asks for.
    fn is_of_kind(&self, parts: &[Part], at: usize) -> bool {
        let end = at + self.parts.len();
        let is_name = parts[at].is_code && parts[at + 1..end].iter().all(|p| p.join == Join::Name);
        let is_whole = parts[at].join != Join::Name
            && parts.get(end).is_none_or(|next| next.join != Join::Name);
        match self.word.kind {
            Kind::Everywhere => true,
            Kind::Names => is_name,
            _ => is_name && is_whole,
        }
    }

    fn is_allowed(&self, parts: &[Part], at: usize) -> bool {
        self.allowed.iter().any(|longer| {
            let begins = at.saturating_sub(longer.len() - 1)..=at;
            begins.into_iter().any(|begin| {
                fits(parts, begin, longer) && begin + longer.len() >= at + self.parts.len()
            })
        })
    }
}

fn capitalized(word: &str) -> String {
    let mut characters = word.chars();
    characters.next().map_or(String::new(), |first| {
        first.to_uppercase().collect::<String>() + characters.as_str()
    })
}

/// Whether a sequence of words stands at a place.
fn fits(parts: &[Part], at: usize, sequence: &[String]) -> bool {
    parts.len() >= at + sequence.len()
        && sequence.iter().zip(&parts[at..]).all(|(wanted, part)| *wanted == part.text)
        && parts[at + 1..at + sequence.len()].iter().all(|part| part.join != Join::Break)
}

/// The offences by retired word and its replacement.
pub fn offences(table: &[Word], sources: &[Source]) -> BTreeMap<(String, String), Vec<String>> {
    let patterns: Vec<Pattern<'_>> = table
        .iter()
        .flat_map(|word| word.retired.iter().map(|retired| Pattern::new(word, retired)))
        .collect();
    let mut found: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for source in sources {
        let bound: Vec<&Pattern<'_>> =
            patterns.iter().filter(|pattern| pattern.word.binds(&source.path)).collect();
        let mut add = |pattern: &Pattern<'_>, place: String| {
            let key = (pattern.retired.to_owned(), pattern.word.instead.clone());
            let places = found.entry(key).or_default();
            if places.last() != Some(&place) {
                places.push(place);
            }
        };
        for pattern in bound.iter().filter(|pattern| names_file(pattern, &source.path)) {
            add(pattern, format!("{}: the path", source.path));
        }
        for line in lines(source) {
            for pattern in bound.iter().filter(|pattern| pattern.is_in(&line)) {
                add(pattern, format!("{}:{}", source.path, line.number));
            }
        }
    }
    found
}

/// Whether a file's path holds the word: in any part, or as a module's name.
fn names_file(pattern: &Pattern<'_>, path: &str) -> bool {
    match pattern.word.kind {
        Kind::Everywhere | Kind::Names => {
            let words = parts(path.rsplit_once('.').map_or(path, |(stem, _)| stem), true);
            (0..words.len())
                .any(|at| fits(&words, at, &pattern.parts) && !pattern.is_allowed(&words, at))
        }
        Kind::Modules => {
            let inner = SOURCES.iter().find_map(|folder| path.strip_prefix(folder));
            let snake = pattern.parts.join("_");
            let mut names = inner.into_iter().flat_map(|inner| inner.split('/'));
            names.any(|name| name.trim_end_matches(".rs") == snake)
        }
        _ => false,
    }
}
