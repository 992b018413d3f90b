//! Wrong commands and files that a newcomer tries: each message names file, place and
//! correction.
//! `tests/data/newcomer.txt` is the table.

#![allow(clippy::unwrap_used, reason = "a test ends where the table is not as it should be")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use command::{finish, surefoot};

/// What of configs/ the cases use.
const FILES: [&str; 4] = [
    "scenarios/flat_walk.toml",
    "worlds/flat_walk.toml",
    "robots/hubo/robot.toml",
    "robots/hubo/hubo.urdf",
];
/// Cases in the table, at least.
const CASES_MIN: usize = 40;

/// A row of the table.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
struct Case {
    subject: String,
    /// File, text and replacement.
    change: Option<[String; 3]>,
    arguments: Vec<String>,
    /// The lines of stderr.
    errors: Vec<String>,
}

fn table() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/newcomer.txt")
}

/// The comment at the head of the table, and its cases.
fn read_table() -> (String, Vec<Case>) {
    let text = fs::read_to_string(table()).unwrap();
    let (head, rest) = text.split_once("\n\n").unwrap();
    (head.to_owned(), rest.split("\n\n").map(case_of).collect())
}

fn case_of(block: &str) -> Case {
    let mut case = Case::default();
    for line in block.lines() {
        if let Some(subject) = line.strip_prefix("# ") {
            case.subject = subject.to_owned();
        } else if let Some(change) = line.strip_prefix("change ") {
            let parts: Vec<String> = change.split('|').map(|part| part.trim().to_owned()).collect();
            case.change = Some(parts.try_into().unwrap());
        } else if let Some(arguments) = line.strip_prefix("$ ") {
            case.arguments = arguments.split(' ').map(str::to_owned).collect();
        } else {
            case.errors.push(line.to_owned());
        }
    }
    case
}

/// What the command says in a copy of configs/ with the case's change.
fn errors_of(case: &Case) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    for file in FILES {
        let copy = folder.path().join(file);
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(configs.join(file), copy).unwrap();
    }
    if let Some([file, from, to]) = &case.change {
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{}: '{from}' is not in {file}", case.subject);
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
    let arguments: Vec<&str> = case.arguments.iter().map(String::as_str).collect();
    let output = finish(surefoot(&arguments).current_dir(folder.path()).spawn().unwrap());
    assert_eq!(output.code, 2, "{}: {}{}", case.subject, output.out, output.err);
    assert_eq!(output.out, "", "{}", case.subject);
    assert!(!folder.path().join("mine").exists(), "{}: a folder is left", case.subject);
    let here = folder.path().canonicalize().unwrap();
    let text = output.err.replace(here.to_str().unwrap(), "DIR");
    let shared = |line: &str| line.replace(&format!("surefoot-{}", users()), "surefoot-USER");
    text.lines().filter(|line| line.starts_with("error: ")).map(shared).collect()
}

fn users() -> u32 {
    use std::os::unix::fs::MetadataExt;
    fs::metadata("/proc/self").unwrap().uid()
}

fn written(head: &str, cases: &[Case]) -> String {
    let mut text = format!("{head}\n");
    for case in cases {
        let _ = write!(text, "\n# {}\n", case.subject);
        if let Some([file, from, to]) = &case.change {
            let _ = writeln!(text, "{}", format!("change {file} | {from} | {to}").trim_end());
        }
        let _ = writeln!(text, "$ {}", case.arguments.join(" "));
        case.errors.iter().for_each(|line| {
            let _ = writeln!(text, "{line}");
        });
    }
    text
}

#[test]
fn each_message_is_the_one_in_the_table() {
    let (head, mut cases) = read_table();
    assert!(cases.len() >= CASES_MIN, "{} cases", cases.len());
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        cases.iter_mut().for_each(|case| case.errors = errors_of(case));
        fs::write(table(), written(&head, &cases)).unwrap();
        return;
    }
    let differing: Vec<String> = cases
        .iter()
        .map(|case| (case, errors_of(case)))
        .filter(|(case, errors)| case.errors != *errors)
        .map(|(case, errors)| format!("{}\n  {}", case.subject, errors.join("\n  ")))
        .collect();
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

#[test]
fn each_message_names_what_it_is_about() {
    for case in read_table().1 {
        let [first, ..] = &case.errors[..] else { panic!("{}: no message", case.subject) };
        let is_changed = case.change.as_ref().is_some_and(|[file, _, to]| {
            let name = file.rsplit('/').next().unwrap();
            first.contains(name) || first.contains(to.trim_matches('"'))
        });
        let is_named = case.arguments.iter().any(|argument| first.contains(argument.as_str()));
        assert!(is_changed || is_named, "{}: {first}", case.subject);
    }
}
