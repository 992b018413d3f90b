//! The files that a run writes: a path that cannot be written is refused before the search, nothing
//! is left half-written, and a file that exists keeps its permissions and links.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt};

use crate::shell::Folder;

#[test]
fn unwritable_outputs_are_refused_before_the_search() {
    let folder = Folder::new();
    folder.good("echo mine >kept; chmod 444 kept; mkdir inner; ln -s loop loop; ln -s no/a hole");
    let long = "x".repeat(300);
    // The search never ends, so an answer comes before it.
    for (path, expected) in [
        ("kept", "write-protected"),
        ("inner", "folder"),
        ("inner/", "folder"),
        ("new/", "folder"),
        ("no/plan.json", "create it first"),
        ("kept/plan.json", "ot a directory"),
        ("loop", "links"),
        ("hole", "create it first"),
        ("endless.toml", "this run reads"),
        ("./inner/../walled.toml", "this run reads"),
        (long.as_str(), "too long"),
    ] {
        for option in ["--export", "--json"] {
            for command in ["plan", "walk"] {
                let err = folder.error(&format!("$S {command} endless.toml {option} {path}"));
                assert!(err.contains(expected), "{path}: {err}");
            }
        }
    }
    let same = "$S plan endless.toml --export same --json inner/../same";
    assert!(folder.error(same).contains("two outputs"));
    assert_eq!(folder.names(), ["hole", "inner", "kept", "loop"]);
    assert_eq!(folder.read("kept"), b"mine\n");
}

#[test]
fn an_existing_file_keeps_its_permissions_and_its_links() {
    let folder = Folder::new();
    folder.good("mkdir inner; echo mine >inner/a; chmod 640 inner/a; ln -s inner/a link");
    folder.good("$S plan flat.toml --quiet --export link --json inner/b");
    assert!(fs::symlink_metadata(folder.path("link")).unwrap().is_symlink());
    let mode = fs::metadata(folder.path("inner/a")).unwrap().permissions().mode();
    assert_eq!(mode & 0o7777, 0o640);
    assert_eq!(folder.json("link")["schema"], "biped-plan/1");
    assert_eq!(folder.json("inner/b")["outcome"], "found");
}

#[test]
fn names_may_be_long_or_no_text() {
    let folder = Folder::new();
    let long = format!("{}.json", "x".repeat(245));
    folder.good(&format!("$S plan flat.toml --quiet --export {long}"));
    folder.good("$S walk flat.toml --quiet --export \"$(printf 'caf\\351.json')\"");
    let name = OsStr::from_bytes(b"caf\xe9.json");
    let path = folder.path("").join(name);
    assert!(fs::metadata(&path).unwrap().len() > 1000);
    folder.good("$S check \"$(printf 'caf\\351.json')\"");
    // A plan file cannot name a world in a folder whose name is no text.
    folder.good("d=$(printf 'd\\351'); mkdir $d; printf 'o\\nf\\n' >$d/m.obj");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.path("").join(OsStr::from_bytes(b"d\xe9/m.obj")), mesh).unwrap();
    let world = "mu = 0.6\n[[shapes]]\nname = \"f\"\nmesh = { path = \"m.obj\" }\n";
    fs::write(folder.path("").join(OsStr::from_bytes(b"d\xe9/w.toml")), world).unwrap();
    let scenario = String::from_utf8(folder.read("flat.toml")).unwrap();
    let line = scenario.lines().find(|line| line.starts_with("world")).unwrap();
    let scenario = scenario.replacen(line, "world = \"w.toml\"", 1);
    fs::write(folder.path("").join(OsStr::from_bytes(b"d\xe9/s.toml")), scenario).unwrap();
    let err = folder.error("$S plan \"$(printf 'd\\351/s.toml')\" --export plan.json");
    assert!(err.contains("no UTF-8"), "{err}");
}

#[test]
fn an_output_may_be_the_standard_output() {
    let folder = Folder::new();
    for command in ["plan", "walk"] {
        for place in ["-", "/dev/stdout", "/dev/fd/1"] {
            let output = folder.good(&format!("$S {command} flat.toml --quiet --export {place}"));
            let plan: serde_json::Value = serde_json::from_str(&output.out).unwrap();
            assert_eq!(plan["schema"], "biped-plan/1", "{command} {place}");
            assert!(output.err.contains("digest"), "{}", output.err);
        }
        let output = folder.good(&format!("$S {command} flat.toml --quiet --json - 2>/dev/null"));
        let report: serde_json::Value = serde_json::from_str(&output.out).unwrap();
        assert!(report["digest"].is_string());
        folder.good(&format!("$S {command} flat.toml --quiet --export - >plan.json"));
        folder.good("$S check plan.json");
        folder.good(&format!("$S {command} flat.toml --quiet --export /dev/fd/3 3>third.json"));
        folder.good("$S check third.json");
        let full = folder.run(&format!("$S {command} flat.toml --quiet --json - >/dev/full"));
        assert_eq!(full.code, 2, "{}", full.err);
    }
}

#[test]
fn an_output_may_be_a_pipe() {
    let folder = Folder::new();
    folder.good("mkfifo pipe");
    for command in ["plan", "walk"] {
        folder.good(&format!(
            "cat pipe >plan.json & $S {command} flat.toml --quiet --export pipe && wait"
        ));
        folder.good("$S check plan.json");
        folder.good(&format!("$S {command} flat.toml --quiet --export /dev/null --json /dev/null"));
    }
    assert_eq!(folder.names(), ["pipe", "plan.json"]);
}

#[test]
fn a_file_that_was_left_half_written_is_removed_by_the_next_run() {
    let folder = Folder::new();
    folder.write(".surefoot-77-0.tmp", "half");
    folder.good("$S plan flat.toml --quiet --export plan.json");
    assert_eq!(folder.names(), ["plan.json"]);
}

#[test]
fn the_last_good_file_stays_where_a_run_finds_nothing() {
    let folder = Folder::new();
    folder.good("$S plan flat.toml --quiet --export plan.json --json report.json");
    let before = fs::metadata(folder.path("plan.json")).unwrap();
    let line = "sed 's/work_max = .*/work_max = 2000/' endless.toml >none.toml; \
                $S plan none.toml --quiet --export plan.json --json report.json";
    assert_eq!(folder.run(line).code, 3);
    let after = fs::metadata(folder.path("plan.json")).unwrap();
    assert_eq!((before.ino(), before.len()), (after.ino(), after.len()));
    assert_eq!(folder.json("report.json")["outcome"], "budget_exhausted");
}

#[test]
fn a_picture_is_drawn_also_where_there_is_no_plan() {
    let folder = Folder::new();
    folder.good("sed 's/work_max = .*/work_max = 4000/' endless.toml >none.toml");
    folder.good("sed 's/xyz = .0.5, 0.0, 0.0./xyz = [0.5, 0.0, 3.0]/' flat.toml >air.toml");
    for (command, scenario, picture, code) in
        [("walk", "none", "a.png", 3), ("plan", "none", "b.apng", 3), ("plan", "air", "c.png", 2)]
    {
        let line = format!("$S {command} {scenario}.toml --quiet --picture {picture}");
        let output = folder.run(&line);
        assert_eq!(output.code, code, "{line}: {}{}", output.out, output.err);
        assert!(folder.read(picture).starts_with(b"\x89PNG"), "{line}");
    }
}

#[test]
fn a_planner_that_serves_refuses_files_that_it_would_not_write() {
    let folder = Folder::new();
    for option in ["--export a.json", "--json a.json", "--picture a.png"] {
        let err = folder.error(&format!("$S plan flat.toml --instance x --serve {option}"));
        assert!(err.contains("--serve writes no files"), "{err}");
    }
}
