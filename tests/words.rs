//! The project's words: no retired one is in use, and the glossary names what exists.
//!
//! `tests/data/retired_words.toml` is the table. `docs/GLOSSARY.md` lists the terms.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "words/glossary.rs"]
mod glossary;
#[path = "architecture/lexer.rs"]
mod lexer;
#[path = "common/markdown.rs"]
mod markdown;
#[path = "words/scan.rs"]
mod scan;
#[path = "architecture/source.rs"]
mod source;
#[path = "words/table.rs"]
mod table;
#[path = "words/text.rs"]
mod text;

use scan::offences;
use source::{Source, read_tree, root};
use table::{Kind, Word, matches, parse};

const TABLE: &str = "tests/data/retired_words.toml";
const GLOSSARY_ROWS_MAX: usize = 40;

/// What is read, and the extensions that are read there.
const PLACES: [(&str, &[&str]); 13] = [
    ("src", &["rs"]),
    ("planner", &["rs", "toml", "md"]),
    ("controller-sim", &["rs", "toml", "md"]),
    ("shared-types", &["rs", "toml", "md"]),
    ("tests", &["rs"]),
    ("benches", &["rs"]),
    ("examples", &["rs", "md"]),
    ("tools", &["py", "sh", "h", "c", "rs"]),
    ("configs", &["toml", "md"]),
    ("docs", &["md"]),
    ("README.md", &["md"]),
    ("CONTRIBUTING.md", &["md"]),
    ("CHANGELOG.md", &["md"]),
];

/// This test's own sources hold the words that it plants.
const OWN: [&str; 2] = ["tests/words.rs", "tests/words/"];

fn table() -> Vec<Word> {
    parse(&std::fs::read_to_string(root().join(TABLE)).unwrap())
}

fn sources() -> Vec<Source> {
    let mut sources: Vec<Source> =
        PLACES.iter().flat_map(|(path, extensions)| read_tree(path, extensions)).collect();
    sources.retain(|source| !OWN.iter().any(|own| source.path.starts_with(own)));
    sources
}

#[test]
fn no_retired_word_is_in_use() {
    let found = offences(&table(), &sources());
    let mut groups: Vec<_> = found.iter().collect();
    groups.sort_by_key(|(_, places)| std::cmp::Reverse(places.len()));
    let mut text = String::new();
    for ((retired, instead), places) in groups {
        text += &format!("\n\"{retired}\" ({} lines), instead: {instead}\n", places.len());
        text += &places.iter().map(|place| format!("  {place}\n")).collect::<String>();
    }
    let lines: usize = found.values().map(Vec::len).sum();
    assert!(found.is_empty(), "{lines} lines with {} retired words\n{text}", found.len());
}

#[test]
fn the_glossary_is_short_and_names_what_exists() {
    let text = std::fs::read_to_string(root().join("docs/GLOSSARY.md")).unwrap();
    let rows = glossary::rows(&text);
    assert!(!rows.is_empty() && rows.len() <= GLOSSARY_ROWS_MAX, "{} rows", rows.len());
    let crates = ["src", "planner/src", "controller-sim/src", "shared-types/src"];
    let sources: Vec<Source> = crates.iter().flat_map(|path| read_tree(path, &["rs"])).collect();
    let mut absent = vec![];
    for row in &rows {
        assert_eq!(row.len(), 4, "{row:?}");
        let names = glossary::names(row);
        assert!(!names.is_empty(), "{row:?}: names no type");
        absent.extend(names.into_iter().filter(|name| !glossary::exists(name, &sources)));
    }
    assert!(absent.is_empty(), "docs/GLOSSARY.md names what does not exist: {absent:?}");
}

#[test]
fn the_glossary_holds_no_retired_word() {
    let sources = read_tree("docs/GLOSSARY.md", &["md"]);
    assert_eq!(sources.len(), 1);
    assert!(offences(&table(), &sources).is_empty());
}

/// The retired words that a table with one row finds in a file.
fn found(row: &str, path: &str, text: &str) -> usize {
    let table = parse(&format!("word = [{{ {row}, instead = \"\" }}]"));
    let source = Source { path: path.to_owned(), text: text.to_owned() };
    offences(&table, &[source]).values().map(Vec::len).sum()
}

#[test]
fn retired_words_are_found_everywhere() {
    let row = "retired = [\"way back\"], kind = \"everywhere\"";
    for text in ["let way_back = 1;", "struct WayBack;", "const WAY_BACK: u8;", "// the way back"] {
        assert_eq!(found(row, "a.rs", text), 1, "{text}");
    }
    assert_eq!(found(row, "a.rs", "/* a\n way-back */ print(\"way back\");"), 1);
    assert_eq!(found(row, "way_back.rs", ""), 1);
    assert_eq!(found(row, "a.md", "A way\nback. Away, back. `away_backwards`"), 0);
}

#[test]
fn names_and_whole_names_and_definitions_are_told_apart() {
    let names = "retired = [\"wants\"], kind = \"names\"";
    assert_eq!(found(names, "a.rs", "fn wants_more() {} // he wants"), 1);
    assert_eq!(found(names, "a.md", "He wants `wants`."), 1);
    assert_eq!(found(names, "a.md", "He wants."), 0);
    let whole = "retired = [\"held\"], kind = \"identifiers\"";
    assert_eq!(found(whole, "a.rs", "let held = held_by(1);"), 1);
    assert_eq!(found(whole, "a.rs", "let held_by = upheld; // held"), 0);
    let types = "retired = [\"end fault\"], kind = \"types\"";
    assert_eq!(found(types, "a.rs", "pub enum EndFault {"), 1);
    assert_eq!(found(types, "a.rs", "use other::EndFault;"), 0);
    let modules = "retired = [\"bell\"], kind = \"modules\"";
    assert_eq!(found(modules, "src/bell.rs", "mod bell;"), 2);
    assert_eq!(found(modules, "tests/bell.rs", "let bell = 1;"), 0);
}

#[test]
fn allowed_uses_are_free() {
    let row = "retired = [\"truth\"], kind = \"everywhere\", allowed = [\"ground truth\"]";
    assert_eq!(found(row, "a.md", "Ground truth, `GroundTruth`, --ground-truth, ground_truth."), 0);
    assert_eq!(found(row, "a.md", "The truth about ground truth."), 1);
    let row =
        "retired = [\"lane\"], kind = \"everywhere\", within = [\"a/*\"], except = [\"a/b*\"]";
    assert_eq!(found(row, "a/c.rs", "lane"), 1);
    assert_eq!(found(row, "a/b.rs", "lane") + found(row, "c.rs", "lane"), 0);
    let row = "retired = [\"lane\"], kind = \"everywhere\"";
    assert_eq!(found(row, "CHANGELOG.md", "| `lane` | `search` |\n"), 0);
    assert_eq!(found(row, "CHANGELOG.md", "A lane.\n"), 1);
}

#[test]
fn globs_match_paths() {
    assert!(matches("a/*.rs", "a/b/c.rs") && matches("a*", "a") && matches("*", "a/b"));
    assert!(!matches("a/*.rs", "b/a/c.rs") && !matches("a", "ab"));
}

#[test]
fn every_row_of_the_table_says_what_to_use_instead() {
    for word in table() {
        assert!(!word.retired.is_empty() && !word.instead.is_empty(), "{word:?}");
        let is_lower = |text: &String| {
            text.chars().all(|c| c.is_ascii_lowercase() || c == ' ') && !text.is_empty()
        };
        assert!(word.retired.iter().chain(&word.allowed).all(is_lower), "{word:?}");
        let is_bound_to_code = word.kind != Kind::Everywhere || word.retired[0].len() > 3;
        assert!(is_bound_to_code || word.retired == ["hop", "hops"], "too short: {word:?}");
    }
}
