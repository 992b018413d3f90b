//! The rows of `docs/GLOSSARY.md`, and whether what they name exists.

use regex::Regex;

use crate::markdown::cells;
use crate::source::Source;

/// The rows of the glossary's table: the cells of each.
pub fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().filter_map(cells).skip(2).collect()
}

/// What the last column of a row names.
pub fn names<'t>(row: &[&'t str]) -> Vec<&'t str> {
    row.last().map_or(vec![], |cell| cell.split('`').skip(1).step_by(2).collect())
}

/// Whether a type or a module of this name exists; `a::b` stands for `b` in a folder or module `a`.
pub fn exists(name: &str, sources: &[Source]) -> bool {
    let parts: Vec<&str> = name.split("::").collect();
    let last = parts[parts.len() - 1];
    let above = &parts[..parts.len() - 1];
    let is_within = |path: &str| {
        let folders: Vec<&str> = path.trim_end_matches(".rs").split('/').collect();
        above.iter().all(|part| folders.contains(part))
    };
    if last.starts_with(char::is_uppercase) {
        let text = format!(r"(?m)^\s*pub(?:\([a-z]+\))? (?:struct|enum|trait|type) {last}\b");
        let definition = Regex::new(&text).unwrap();
        return sources.iter().any(|one| is_within(&one.path) && definition.is_match(&one.text));
    }
    let is_module = |path: &str| {
        let stem = path.trim_end_matches("/mod.rs").trim_end_matches(".rs");
        stem.rsplit('/').next() == Some(last) && is_within(path)
    };
    sources.iter().any(|one| is_module(&one.path))
}
