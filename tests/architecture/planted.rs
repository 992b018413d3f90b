//! Every rule is shown to see an offence that is planted in a small set of sources.

use crate::Source;
use crate::floors::{Crate, Floor, Imports};
use crate::forbidden::{self, RULES};
use crate::house::House;
use crate::picture;
use crate::rules::{self, Read, with_read};
use crate::sizes::{self, Function};
use crate::types;

const fn floor(folder: &'static str, imports: Imports) -> Floor {
    Floor { folder, imports }
}

const CRATES: [Crate; 2] = [
    Crate {
        name: "surefoot_planner",
        sources: "planner/src",
        root_files: &["lib.rs"],
        floors: &[
            floor("base", Imports::These(&[])),
            floor("possibility", Imports::UpTo("base", &[])),
            floor("motion", Imports::These(&["base"])),
            floor("pipeline", Imports::UpTo("motion", &[])),
        ],
    },
    Crate {
        name: "surefoot",
        sources: "src",
        root_files: &["lib.rs", "main.rs"],
        floors: &[floor("cli", Imports::These(&[]))],
    },
];

fn source(path: &str, text: &str) -> Source {
    Source { path: path.to_owned(), text: text.to_owned() }
}

fn house(files: &[(&str, &str)]) -> House {
    House::new(&CRATES, files.iter().map(|(path, text)| source(path, text)).collect())
}

fn offences(files: &[(&str, &str)], rule: impl Fn(&Read<'_>) -> Vec<String>) -> Vec<String> {
    with_read(&house(files), rule)
}

#[track_caller]
fn assert_one(offences: &[String], expected: &str) {
    assert_eq!(offences.len(), 1, "{offences:#?}");
    assert!(offences[0].contains(expected), "{}", offences[0]);
}

/// A house in order: re-exports, a module and a function of one name, unit tests.
const ORDERLY: [(&str, &str); 10] = [
    ("planner/src/lib.rs", "pub mod base;\npub mod motion;\npub use motion::Path;\n"),
    (
        "planner/src/base/mod.rs",
        "//! Memory.\npub mod arena;\npub mod draw;\npub use draw::draw;\n",
    ),
    ("planner/src/base/arena.rs", "use super::draw::draw;\npub struct Arena(u8);\n"),
    (
        "planner/src/base/draw.rs",
        "pub fn draw() {}\n#[cfg(test)]\nmod tests {\n    use crate::base::arena::Arena;\n}\n",
    ),
    ("planner/src/possibility/mod.rs", "pub mod tree;\n"),
    ("planner/src/possibility/tree.rs", "use crate::base::{self, arena::Arena};\n"),
    ("planner/src/motion/mod.rs", "mod path;\npub use path::Path;\n"),
    ("planner/src/motion/path.rs", "use crate::base::draw;\npub struct Path;\n"),
    (
        "planner/src/pipeline/planner.rs",
        "use crate::motion::Path;\nfn f() { assert!(crate::possibility::tree::is_it()); }\n",
    ),
    ("src/main.rs", "use surefoot_planner::Path;\nfn main() {}\n"),
];

#[test]
fn an_orderly_house_has_no_offence() {
    let rules: [fn(&Read<'_>) -> Vec<String>; 7] = [
        rules::circles,
        rules::loose_files,
        rules::undeclared_folders,
        rules::upward_arrows,
        rules::roots_that_define,
        rules::both_stages,
        rules::imports_through_parents,
    ];
    for rule in rules {
        assert_eq!(offences(&ORDERLY, rule), Vec::<String>::new());
    }
}

#[test]
fn imports_are_followed_to_the_file_that_defines() {
    let house = house(&ORDERLY);
    let arrows = with_read(&house, |read| {
        let path = |file: usize| house.files[file].path.clone();
        read.arrows.keys().map(|&(from, to)| (path(from), path(to))).collect::<Vec<_>>()
    });
    let has = |from: &str, to: &str| arrows.contains(&(from.to_owned(), to.to_owned()));
    assert!(has("planner/src/pipeline/planner.rs", "planner/src/motion/path.rs"));
    assert!(has("planner/src/motion/path.rs", "planner/src/base/draw.rs"));
    assert!(has("planner/src/base/arena.rs", "planner/src/base/draw.rs"));
    assert!(has("src/main.rs", "planner/src/motion/path.rs"));
    assert!(!has("planner/src/base/draw.rs", "planner/src/base/arena.rs"), "only its tests do");
}

#[test]
fn a_circle_is_found_in_imports_bodies_types_macros_and_attributes() {
    let ways = [
        "use crate::base::b::g;",
        "use super::b::{self, g};",
        "use super::b;\nfn f() { b::g() }",
        "fn f() { crate::base::b::g() }",
        "fn f() { super::b::g() }",
        "fn f() -> Vec<super::b::B> { vec![] }",
        "fn f() { assert!(crate::base::b::g(1) > 0) }",
        "fn f() { use super::b::*; g() }",
        "use crate::base::g;",
        "use super::*;\nfn f() { g() }",
        "struct S { #[serde(with = \"crate::base::b::g\")] s: u8 }",
        "mod inner { fn f() { super::super::b::g() } }",
    ];
    for way in ways {
        let text = format!("{way}\npub struct A;\n");
        let files = [
            ("planner/src/base/mod.rs", "mod a;\nmod b;\npub use b::g;\n"),
            ("planner/src/base/a.rs", text.as_str()),
            ("planner/src/base/b.rs", "use super::a::A;\npub fn g() {}\npub struct B;\n"),
        ];
        let found = offences(&files, rules::circles);
        assert_eq!(found.len(), 1, "{way}: {found:#?}");
        assert!(found[0].contains("files import each other"), "{way}: {}", found[0]);
    }
}

#[test]
fn a_circle_of_three_files_over_two_folders_is_found() {
    let files = [
        ("planner/src/base/a.rs", "use crate::motion::c::C;\npub struct A;\n"),
        ("planner/src/base/b.rs", "use super::a::A;\npub struct B;\n"),
        ("planner/src/motion/c.rs", "use crate::base::b::B;\npub struct C;\n"),
    ];
    assert_one(&offences(&files, rules::circles), "3 files import each other");
}

#[test]
fn an_upward_and_an_undeclared_arrow_are_found() {
    let up = [
        ("planner/src/base/a.rs", "fn f(p: &crate::motion::Path) {}\n"),
        ("planner/src/motion/mod.rs", "mod path;\npub use path::Path;\n"),
        ("planner/src/motion/path.rs", "pub struct Path;\n"),
    ];
    assert_one(&offences(&up, rules::upward_arrows), "a.rs:1: upward: base imports motion");
    let aside = [
        ("planner/src/motion/a.rs", "use crate::possibility::tree::Tree;\n"),
        ("planner/src/possibility/tree.rs", "pub struct Tree;\n"),
    ];
    assert_one(&offences(&aside, rules::upward_arrows), "undeclared: motion imports possibility");
}

#[test]
fn loose_files_and_undeclared_folders_are_found() {
    let files = [("planner/src/lib.rs", ""), ("planner/src/loose.rs", ""), ("src/main.rs", "")];
    assert_one(&offences(&files, rules::loose_files), "planner/src/loose.rs");
    let files = [("src/cli/mod.rs", ""), ("src/attic/mod.rs", "")];
    assert_one(&offences(&files, rules::undeclared_folders), "src/attic");
    let absent = offences(&ORDERLY, rules::absent_folders);
    assert_one(&absent, "src/cli: no such folder");
}

#[test]
fn a_module_root_that_defines_is_found() {
    for text in ["fn f() {}", "struct S;", "const N: u8 = 0;", "mod inner { }", "impl S {}"] {
        let found = offences(&[("planner/src/base/mod.rs", text)], rules::roots_that_define);
        assert_one(&found, "planner/src/base/mod.rs: defines");
        let found = offences(&[("src/lib.rs", text)], rules::roots_that_define);
        assert_one(&found, "src/lib.rs: defines");
    }
}

#[test]
fn an_import_through_the_own_root_is_found() {
    let root = ("planner/src/base/mod.rs", "mod a;\nmod b;\npub use b::B;\npub const N: u8 = 0;\n");
    let lib = ("planner/src/lib.rs", "pub mod base;\npub use base::B;\n");
    let b = ("planner/src/base/b.rs", "pub struct B;\n");
    for (import, expected) in [
        ("use super::B;", "through its mod.rs: super::B"),
        ("use crate::base::B;", "through its mod.rs: crate::base::B"),
        ("use super::N;", "through its mod.rs: super::N"),
        ("use crate::B;", "through its lib.rs: crate::B"),
        ("fn f(b: crate::B) {}", "through its lib.rs: crate::B"),
    ] {
        let files = [root, lib, b, ("planner/src/base/a.rs", import)];
        assert_one(&offences(&files, rules::imports_through_parents), expected);
    }
    let files = [root, lib, b, ("planner/src/base/a.rs", "use super::b::B;")];
    assert!(offences(&files, rules::imports_through_parents).is_empty());
}

#[test]
fn a_file_that_knows_both_stages_is_found() {
    let stages = [
        ("planner/src/motion/path.rs", "pub struct Path;\n"),
        ("planner/src/possibility/tree.rs", "pub struct Tree;\n"),
    ];
    let both = "use crate::{motion::path::Path, possibility::tree::Tree};\n";
    let files = [stages[0], stages[1], ("planner/src/base/a.rs", both)];
    assert_one(&offences(&files, rules::both_stages), "planner/src/base/a.rs");
    let files = [stages[0], stages[1], ("planner/src/pipeline/a.rs", both)];
    assert!(offences(&files, rules::both_stages).is_empty());
}

#[test]
fn an_import_of_the_whole_planner_is_found() {
    let files = [
        ("planner/src/pipeline/mod.rs", "mod planner;\npub use planner::Planner;\n"),
        ("planner/src/pipeline/planner.rs", "pub struct Planner;\n"),
        ("planner/src/pipeline/route_stage.rs", "use super::planner::Planner;\n"),
    ];
    assert_one(&offences(&files, rules::imports_of_the_planner), "route_stage.rs:1");
}

#[test]
fn impl_blocks_in_three_files_are_found() {
    let files = [
        ("planner/src/base/a.rs", "pub struct A;\nimpl A {}\nimpl Drop for A { }\n"),
        ("planner/src/base/b.rs", "use super::a::A;\nimpl A {}\n"),
        ("planner/src/base/c.rs", "use crate::base::a as own;\nimpl From<u8> for own::A {}\n"),
    ];
    assert_one(&types::scattered_types(&house(&files)), "impl of A in planner/src/base/a.rs, ");
    assert!(types::scattered_types(&house(&files[..2])).is_empty());
}

#[test]
fn a_type_with_methods_and_thirteen_fields_is_found() {
    let with = |fields: usize, methods: &str| {
        let fields: String = (0..fields).map(|at| format!("f{at}: u8, ")).collect();
        let text = format!("pub struct Wide {{ {fields} }}\nimpl Wide {{ {methods} }}\n");
        types::wide_types(&house(&[("planner/src/base/a.rs", &text)]))
    };
    assert_one(&with(13, "fn f(&self) {}"), "a.rs:1: Wide has 13 fields");
    assert!(with(12, "fn f(&self) {}").is_empty());
    assert!(with(13, "fn new() -> Wide { todo!() }").is_empty(), "a record may have a constructor");
    let derived = |derives: &str| {
        let fields: String = (0..13).map(|at| format!("f{at}: u8, ")).collect();
        let text = format!("{derives} struct R {{ {fields} }}\nimpl R {{ fn f(&self) {{}} }}\n");
        types::wide_types(&house(&[("planner/src/base/a.rs", &text)])).len()
    };
    assert_eq!(derived("#[derive(Debug, Clone)]"), 1);
    assert_eq!(derived("#[derive(Debug, serde::Serialize)]"), 0);
    assert_eq!(derived("#[derive(Clone, Pod)]"), 0);
}

#[test]
fn forbidden_words_are_found_in_code_and_in_braces() {
    let found = |path: &str, text: &str| {
        let sources = [source(path, text)];
        offences(&[(path, text)], |read| forbidden::offences(read, &sources))
    };
    let path = "planner/src/base/a.rs";
    assert_one(&found(path, "fn f() { std::fs::read(\"\") }"), "a.rs:1: std::fs");
    assert_one(&found(path, "use std::{\n    fs,\n};"), "a.rs:2: std::fs");
    assert_one(&found(path, "use std::time::Duration;"), "no clock");
    assert_one(&found(path, "use std::collections::HashMap;"), "no fixed order");
    assert_one(&found(path, "use iceoryx2::prelude::Node;"), "shared memory");
    assert_one(&found(path, "use crate::pipeline::Planner;\n").split_off(1), "pipeline");
    assert!(found(path, "// iceoryx2 and std::fs\nfn f() {} // std::time\n").is_empty());
    assert!(found("planner/src/channel/a.rs", "use iceoryx2::prelude::Node;").is_empty());
    for rule in &RULES {
        for word in rule.words {
            let planted = source(rule.binds[0], &format!("x = {word}"));
            assert!(!rule.offences(&planted).is_empty(), "{}: {word}", rule.why);
        }
    }
}

#[test]
fn long_files_functions_and_lines_are_found() {
    let text = "fn f() {\n".to_owned() + &"    g();\n".repeat(600) + "}\n";
    let files = house(&[("planner/src/base/a.rs", &text)]);
    assert_one(&sizes::long_files(&files), "a.rs: 602 lines");
    assert_one(&sizes::long_functions(&files), "a.rs:1: fn f: 602 lines");
    let text = "#[inline]\npub fn one(\n    a: u8,\n) {\n    if a > 0 {\n    }\n}\n";
    let one = Function { name: "one".to_owned(), line: 2, lines: 6 };
    assert_eq!(sizes::functions(&syn::parse_file(text).unwrap()), [one]);
}

#[test]
fn long_lines_are_found_but_in_literals_and_addresses() {
    let long = "word ".repeat(30);
    let found = |text: &str| sizes::long_lines(&source("a.rs", text)).len();
    assert_eq!(found(&format!("// {long}")), 1);
    assert_eq!(found(&format!("let a = f({});", "a, ".repeat(40))), 1);
    assert_eq!(found(&format!("let a = \"{long}\"; // {long}")), 0);
    assert_eq!(found(&format!("let a = \"a\"; // {long}")), 1);
    assert_eq!(found(&format!("/// https://{}", "a".repeat(120))), 0);
    assert_eq!(found(&format!("let a = r#\"\n{long}\n\"#;")), 0);
    let prose = |text: &str| sizes::long_prose(&source("a.md", text)).len();
    assert_eq!(prose(&long), 1);
    assert_eq!(prose(&format!("| {long} |\n```\n{long}\n```\n")), 0);
}

#[test]
fn the_floors_are_drawn_between_their_markers() {
    let house = house(&ORDERLY);
    let section = picture::section(&house);
    let top = "    planner_pipeline[pipeline] --> planner_motion[motion] & planner_possibility[";
    assert!(section.contains(top), "{section}");
    assert!(section.contains("    planner_possibility --> planner_base\n"), "{section}");
    let document = "before\n<!-- floors -->\nold\n<!-- /floors -->\nafter\n";
    let drawn = picture::with_section(document, "new\n").unwrap();
    assert_eq!(drawn, "before\n<!-- floors -->\nnew\n<!-- /floors -->\nafter\n");
    assert!(picture::with_section("no markers", "new").is_none());
}

#[test]
fn the_lexer_separates_code_comments_and_literals() {
    use crate::lexer::{Kind, pieces};
    let text =
        "let a = 'a'; let b: &'a str = r#\"// \"no\" \"#; // \"yes\"\n/* a /* b */ c */ '\\''";
    let kinds = |kind: Kind| -> Vec<&str> {
        pieces(text).iter().filter(|one| one.kind == kind).map(|one| one.text).collect()
    };
    assert_eq!(kinds(Kind::Literal), ["r#\"// \"no\" \"#"]);
    assert_eq!(kinds(Kind::Comment), ["// \"yes\"", "/* a /* b */ c */"]);
}
