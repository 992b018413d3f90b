//! The program works from any folder: it carries scenarios, robots and worlds, and describes
//! itself to a shell and a reader of manual pages.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::path::Path;

use command::{CommandOutput, finish, surefoot};

/// Runs the command in an empty folder with an empty cache.
fn run_in(folder: &Path, arguments: &[&str]) -> CommandOutput {
    let mut command = surefoot(arguments);
    command.current_dir(folder).env("XDG_CACHE_HOME", folder.join("cache"));
    finish(command.spawn().unwrap())
}

#[test]
fn a_scenario_walks_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_in(folder.path(), &["walk", "ibeam_gap", "--quiet", "--export", "plan.json"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let output = run_in(folder.path(), &["check", "plan.json", "--scenario", "ibeam_gap"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let output = run_in(folder.path(), &["picture", "plan.json", "walk.png"]);
    assert_eq!((output.code, output.err.as_str()), (0, ""));
    assert!(folder.path().join("walk.png").metadata().unwrap().len() > 10_000);
    let output = run_in(folder.path(), &["explain", "plan.json"]);
    assert_eq!((output.code, output.err.as_str()), (0, ""));
    let steps = " s a step, ";
    let last = "the controller's checks accept this plan\n";
    assert!(output.out.contains(steps) && output.out.ends_with(last), "{}", output.out);
}

#[test]
fn a_name_gives_way_to_a_file_and_damage_in_the_cache_is_mended() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(run_in(folder.path(), &["config", "show", "beam"]).code, 0);
    let cache = std::fs::read_dir(folder.path().join("cache/surefoot")).unwrap();
    let scenario = cache.last().unwrap().unwrap().path().join("scenarios/beam.toml");
    std::fs::write(&scenario, "damaged").unwrap();
    assert_eq!(run_in(folder.path(), &["config", "show", "beam"]).code, 0);
    // A pipe in the file's place is replaced and not waited for.
    std::fs::remove_file(&scenario).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&scenario).status().unwrap().success());
    assert_eq!(run_in(folder.path(), &["config", "show", "beam"]).code, 0);
    assert!(scenario.metadata().unwrap().is_file());
    std::fs::write(folder.path().join("beam"), "not a scenario").unwrap();
    let output = run_in(folder.path(), &["config", "show", "beam"]);
    assert_eq!(output.code, 2, "{}", output.out);
    let output = run_in(folder.path(), &["plan", "stares"]);
    assert_eq!(output.code, 2);
    assert!(output.err.contains("did you mean 'stairs'?"), "{}", output.err);
}

#[test]
fn a_new_scenario_walks_and_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_in(folder.path(), &["new", "first"]);
    assert_eq!((output.code, output.err.as_str()), (0, ""));
    let output = run_in(folder.path(), &["walk", "first/scenario.toml", "--quiet"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let output = run_in(folder.path(), &["new", "first"]);
    assert_eq!(output.code, 2);
    assert!(
        output.err.contains("first/world.toml: cannot be written: it exists"),
        "{}",
        output.err
    );
}

#[test]
fn the_list_names_every_shipped_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let (text, json) =
        (run_in(folder.path(), &["list"]), run_in(folder.path(), &["list", "--json"]));
    assert_eq!((text.code, json.code), (0, 0));
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/scenarios");
    for entry in std::fs::read_dir(configs).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(text.out.lines().any(|line| line.starts_with(&format!("  {name} "))), "{name}");
        assert!(json.out.contains(&format!("\"name\":\"{name}\"")), "{name}");
    }
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(run_in(folder.path(), &["man", "pages"]).code, 0);
    for shell in ["bash", "zsh", "fish"] {
        let output = run_in(folder.path(), &["completions", shell]);
        assert!(output.code == 0 && output.out.contains("request"), "{shell}");
    }
    for command in ["walk", "plan", "check", "bench-scale", "config-show"] {
        let page = folder.path().join(format!("pages/surefoot-{command}.1"));
        assert!(page.is_file(), "{}", page.display());
    }
}

#[test]
fn the_viewer_is_run_by_python_or_the_message_says_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let plan = ["plan", "ibeam_gap", "--quiet", "--export", "plan.json"];
    assert_eq!(run_in(folder.path(), &plan).code, 0);
    let view = |interpreter: &str| {
        let mut command = surefoot(&["view", "plan.json", "--save", "walk.rrd"]);
        command.current_dir(folder.path()).env("SUREFOOT_PYTHON", interpreter);
        finish(command.spawn().unwrap())
    };
    let output = view("/nowhere/python3");
    assert_eq!(output.code, 2);
    assert!(output.err.contains("/nowhere/python3 cannot be run"), "{}", output.err);
    let output = view("false");
    assert_eq!(output.code, 2);
    assert!(output.err.contains("pip install 'surefoot[view]'"), "{}", output.err);
    let output = view("echo");
    assert_eq!(output.code, 0, "{}", output.err);
    assert_eq!(output.out, "-m surefoot.view plan.json --save walk.rrd\n");
}
