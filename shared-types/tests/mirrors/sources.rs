//! Comments and constants of the messages, read from their sources.

use std::collections::BTreeMap;
use std::path::Path;

/// A constant, or the value of a variant.
pub struct Constant {
    /// In capitals, with the enum's name before it.
    pub name: String,
    pub value: u64,
    pub comment: String,
}

/// What the sources say.
#[derive(Default)]
pub struct Sources {
    /// Comments of structs, and of fields as `Struct.field`.
    pub comments: BTreeMap<String, String>,
    /// In the order of files and lines.
    pub constants: Vec<Constant>,
}

impl Sources {
    /// Reads all sources of the messages.
    pub fn read() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/message");
        let mut paths: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        let mut sources = Self::default();
        for path in paths {
            sources.read_file(&std::fs::read_to_string(path).unwrap());
        }
        sources
    }

    fn read_file(&mut self, text: &str) {
        // The struct or enum whose lines follow.
        let mut owner: Option<&str> = None;
        let mut comment = String::new();
        for line in text.lines() {
            let trimmed = line.trim();
            if let Some(more) = trimmed.strip_prefix("///") {
                comment = format!("{comment} {}", more.trim()).trim().to_owned();
                continue;
            }
            if trimmed.starts_with("#[") {
                continue;
            }
            let declared = ["pub struct ", "pub enum "]
                .iter()
                .find_map(|keyword| trimmed.strip_prefix(keyword)?.strip_suffix(" {"));
            if let Some(name) = declared {
                owner = Some(name);
                self.comments.insert(name.to_owned(), plain(&comment));
            } else if line == "}" {
                owner = None;
            } else if let Some((name, value)) = constant(trimmed) {
                self.add_constant(name.to_owned(), value, &comment);
            } else if let Some(owner) = owner {
                self.read_member(owner, trimmed, &comment);
            }
            comment.clear();
        }
    }

    fn read_member(&mut self, owner: &str, line: &str, comment: &str) {
        if let Some((field, _)) = line.strip_prefix("pub ").and_then(|rest| rest.split_once(':')) {
            self.comments.insert(format!("{owner}.{field}"), plain(comment));
        } else if let Some((variant, value)) = line.trim_end_matches(',').split_once(" = ")
            && let Ok(value) = value.parse()
        {
            let name = format!("{}_{}", crate::screaming(owner), crate::screaming(variant));
            self.add_constant(name, value, comment);
        }
    }

    fn add_constant(&mut self, name: String, value: u64, comment: &str) {
        self.constants.push(Constant { name, value, comment: plain(comment) });
    }
}

/// A public constant with a number as its value.
fn constant(line: &str) -> Option<(&str, u64)> {
    let (name, rest) = line.strip_prefix("pub const ")?.split_once(": ")?;
    let value = rest.strip_prefix("u64 = ").or_else(|| rest.strip_prefix("u32 = "))?;
    Some((name, value.strip_suffix(';')?.parse().ok()?))
}

/// A comment without links and code quotes.
fn plain(comment: &str) -> String {
    let mut text = String::new();
    let mut rest = comment;
    while let Some((before, after)) = rest.split_once("](") {
        text.push_str(before);
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    text.push_str(rest);
    text.replace("[`", "").replace("`]", "").replace('`', "").replace("*/", "* /")
}
