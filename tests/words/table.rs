//! The table of retired words.

use serde::Deserialize;

/// Where a retired word is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// In names, comments, messages and documents.
    Everywhere,
    /// Within names.
    Names,
    /// As a whole name.
    Identifiers,
    /// As the name of a type's definition.
    Types,
    /// As the name of a function's definition.
    Functions,
    /// As the name of a module or its file.
    Modules,
}

/// A row of the table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Word {
    /// Sequences of words.
    pub retired: Vec<String>,
    /// Where they are looked for.
    pub kind: Kind,
    /// What to use instead.
    pub instead: String,
    /// Globs of the paths where they are retired; everywhere if empty.
    #[serde(default)]
    pub within: Vec<String>,
    /// Globs of the paths where they are allowed.
    #[serde(default)]
    pub except: Vec<String>,
    /// Longer sequences in which they are allowed.
    #[serde(default)]
    pub allowed: Vec<String>,
}

#[derive(Deserialize)]
struct Table {
    word: Vec<Word>,
}

impl Word {
    /// Whether it is retired in a file.
    pub fn binds(&self, path: &str) -> bool {
        let any = |globs: &[String]| globs.iter().any(|glob| matches(glob, path));
        (self.within.is_empty() || any(&self.within)) && !any(&self.except)
    }
}

/// Reads a table.
pub fn parse(text: &str) -> Vec<Word> {
    toml::from_str::<Table>(text).unwrap_or_else(|error| panic!("{error}")).word
}

/// Whether a path matches a glob, in which `*` stands for any characters, `/` among them.
pub fn matches(glob: &str, path: &str) -> bool {
    match glob.split_once('*') {
        None => glob == path,
        Some((before, rest)) => path.strip_prefix(before).is_some_and(|path| {
            path.char_indices().any(|(at, _)| matches(rest, &path[at..])) || matches(rest, "")
        }),
    }
}
