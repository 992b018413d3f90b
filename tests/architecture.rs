//! The rules of the architecture, read off the sources.
//!
//! `cargo test --test architecture -- --nocapture the_floors` prints the floors.
//! `SUREFOOT_BLESS=1 cargo test --test architecture` rewrites the floors in docs/ARCHITECTURE.md.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "architecture/floors.rs"]
mod floors;
#[path = "architecture/forbidden.rs"]
mod forbidden;
#[path = "architecture/graph.rs"]
mod graph;
#[path = "architecture/house.rs"]
mod house;
#[path = "architecture/imports.rs"]
mod imports;
#[path = "architecture/lexer.rs"]
mod lexer;
#[path = "architecture/picture.rs"]
mod picture;
#[path = "architecture/planted.rs"]
mod planted;
#[path = "architecture/resolve.rs"]
mod resolve;
#[path = "architecture/rules.rs"]
mod rules;
#[path = "architecture/sizes.rs"]
mod sizes;
#[path = "architecture/source.rs"]
mod source;
#[path = "architecture/types.rs"]
mod types;

use floors::CRATES;
use house::House;
use rules::{Read, with_read};
use source::{Source, read_tree, root};

/// The folders whose lines are bounded; the crates' sources are among them.
const RUST: [&str; 10] = [
    "src",
    "tests",
    "benches",
    "examples",
    "planner",
    "controller-sim/src",
    "controller-sim/tests",
    "controller-sim/examples",
    "shared-types",
    "tools",
];
/// The documents whose prose is bounded.
const PROSE: [&str; 4] = ["docs", "README.md", "CHANGELOG.md", "CONTRIBUTING.md"];

fn house() -> House {
    let sources = CRATES.iter().flat_map(|krate| read_tree(krate.sources, &["rs"])).collect();
    House::new(&CRATES, sources)
}

/// Fails with every offence on a line of its own.
fn assert_none(what: &str, offences: &[String]) {
    assert!(offences.is_empty(), "{what}: {} offences\n{}", offences.len(), offences.join("\n"));
}

fn assert_rule(what: &str, rule: impl Fn(&Read<'_>) -> Vec<String>) {
    assert_none(what, &with_read(&house(), rule));
}

#[test]
fn the_floors_are_printed() {
    with_read(&house(), |read| {
        println!("{}", picture::table(read));
        let all = graph::circles(&read.arrows).len();
        let strangers = graph::without_families(read.house, &read.arrows);
        let others = graph::circles(&strangers).len();
        println!("circles of files: {others}, {all} with those of parents and children");
    });
}

#[test]
fn no_two_files_import_each_other() {
    assert_rule("circles of imports", rules::circles);
}

#[test]
fn the_root_of_each_crate_holds_its_root_files_alone() {
    assert_rule("loose files", rules::loose_files);
}

#[test]
fn folders_import_only_what_stands_below_them() {
    assert_rule("folders and the arrows between them", |read| {
        let found = [
            rules::undeclared_folders(read),
            rules::absent_folders(read),
            rules::upward_arrows(read),
        ];
        found.concat()
    });
}

#[test]
fn module_roots_declare_and_define_nothing() {
    assert_rule("module roots that define", rules::roots_that_define);
}

#[test]
fn no_file_imports_through_its_own_module_root() {
    assert_rule("imports through mod.rs or lib.rs", rules::imports_through_parents);
}

#[test]
fn impl_blocks_of_a_type_stand_in_two_files_at_most() {
    assert_none("scattered types", &types::scattered_types(&house()));
}

#[test]
fn types_with_behaviour_have_twelve_fields_at_most() {
    assert_none("wide types", &types::wide_types(&house()));
}

#[test]
fn only_the_pipeline_knows_both_stages() {
    assert_rule("files that know both stages", rules::both_stages);
}

#[test]
fn nothing_below_imports_the_planner_as_a_whole() {
    assert_rule("imports of the planner", rules::imports_of_the_planner);
}

#[test]
fn no_source_holds_a_forbidden_word() {
    let sources = forbidden::sources();
    assert_rule("forbidden words", |read| forbidden::offences(read, &sources));
}

#[test]
fn every_rule_of_words_binds_some_file() {
    let sources = forbidden::sources();
    for rule in &forbidden::RULES {
        for bound in rule.binds {
            let is_there = sources.iter().any(|source| source.path.starts_with(bound));
            assert!(is_there, "{}: binds nothing at {bound}", rule.why);
        }
    }
}

#[test]
fn files_and_functions_stay_small() {
    let house = house();
    let seen: usize = house.files.iter().map(|file| sizes::functions(&file.syntax).len()).sum();
    assert!(seen > 500, "only {seen} functions seen");
    assert_none("long files", &sizes::long_files(&house));
    assert_none("long functions", &sizes::long_functions(&house));
}

#[test]
fn lines_of_code_and_comment_have_a_hundred_columns_at_most() {
    let sources = RUST.iter().flat_map(|path| read_tree(path, &["rs"]));
    let offences: Vec<String> = sources.flat_map(|source| sizes::long_lines(&source)).collect();
    assert_none("long lines", &offences);
}

#[test]
fn lines_of_prose_have_a_hundred_columns_at_most() {
    let sources = PROSE.iter().flat_map(|path| read_tree(path, &["md"]));
    let offences: Vec<String> = sources.flat_map(|source| sizes::long_prose(&source)).collect();
    assert_none("long prose", &offences);
}

#[test]
fn the_document_shows_the_floors() {
    let path = root().join("docs/ARCHITECTURE.md");
    let document = std::fs::read_to_string(&path).unwrap();
    let Some(expected) = picture::with_section(&document, &picture::section(&house())) else {
        panic!("docs/ARCHITECTURE.md: no {} .. {}", picture::BEGIN, picture::END);
    };
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        std::fs::write(&path, expected).unwrap();
    } else {
        assert!(
            document == expected,
            "docs/ARCHITECTURE.md shows other floors; rewrite them with \
             SUREFOOT_BLESS=1 cargo test --test architecture the_document_shows_the_floors"
        );
    }
}
