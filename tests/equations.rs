//! `docs/EQUATIONS.md` names files and tests that exist, and claims nothing without naming its
//! code.

#![allow(clippy::unwrap_used, reason = "a test ends where a file cannot be read")]

#[path = "common/markdown.rs"]
mod markdown;

use std::path::Path;

use markdown::cells;

/// A row of one of the tables: what, rule, code, tests, state.
struct Row<'a> {
    line: usize,
    cells: Vec<&'a str>,
}

fn read(path: &str) -> Option<String> {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).ok()
}

fn rows(text: &str) -> Vec<Row<'_>> {
    let numbered = text
        .lines()
        .enumerate()
        .filter_map(|(index, line)| Some(Row { line: index + 1, cells: cells(line)? }));
    numbered.filter(|row| row.cells[0] != "Thesis" && !row.cells[0].starts_with("---")).collect()
}

/// The words in backticks.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

fn has_test(path: &str, name: &str) -> bool {
    let Some(text) = read(path) else { return false };
    let head = format!("fn {name}(");
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    lines.iter().enumerate().any(|(at, line)| {
        line.starts_with(&head) && lines[..at].iter().rev().take(3).any(|line| *line == "#[test]")
    })
}

fn faults(text: &str) -> Vec<String> {
    let mut faults = vec![];
    for Row { line, cells } in rows(text) {
        let mut fault = |what: String| faults.push(format!("line {line}: {what}"));
        let [_, _, code, tests, state] = cells[..] else {
            fault(format!("{} cells, not 5", cells.len()));
            continue;
        };
        for path in quoted(code).filter(|path| read(path).is_none()) {
            fault(format!("no file {path}"));
        }
        for test in quoted(tests) {
            if !test.split_once("::").is_some_and(|(path, name)| has_test(path, name)) {
                fault(format!("no test {test}"));
            }
        }
        for path in quoted(state).filter(|path| read(path).is_none()) {
            fault(format!("no file {path}"));
        }
        let (has_code, has_tests) = (quoted(code).next().is_some(), quoted(tests).next().is_some());
        match state.split(':').next().unwrap_or_default() {
            "done" if !(has_code && has_tests) => {
                fault("done, but without code or test".to_owned())
            }
            "partly" if !has_code || !state.contains(": ") => {
                fault("partly, but without code or remark".to_owned())
            }
            "missing" if has_code => fault("missing, but with code".to_owned()),
            "done" | "partly" | "missing" => {}
            other => fault(format!("'{other}' is no state")),
        }
    }
    faults
}

#[test]
fn every_file_and_test_it_names_exists() {
    let text = read("docs/EQUATIONS.md").unwrap();
    assert!(rows(&text).len() > 60, "only {} rows", rows(&text).len());
    let faults = faults(&text);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn the_fault_of_a_row_is_found() {
    let row = |rest: &str| faults(&format!("| Eq | rule | {rest} |"));
    assert_eq!(
        row("`tests/equations.rs` | `tests/equations.rs::the_fault_of_a_row_is_found` | done"),
        Vec::<String>::new()
    );
    for (rest, expected) in [
        (
            "`tests/no.rs` | `tests/equations.rs::the_fault_of_a_row_is_found` | done",
            "no file tests/no.rs",
        ),
        ("`tests/equations.rs` | `tests/equations.rs::rows` | done", "no test"),
        ("`tests/equations.rs` | | done", "without code or test"),
        ("`tests/equations.rs` | | partly", "without code or remark"),
        ("`tests/equations.rs` | | missing", "with code"),
        ("| | nearly", "is no state"),
        ("| done", "4 cells"),
    ] {
        let found = row(rest);
        assert!(
            found.iter().any(|fault| fault.contains(expected)),
            "'{expected}' is not in {found:?}"
        );
    }
}
