//! `surefoot prepare` and its cache: kept once, read again, made again where it is damaged, and no
//! trouble where it cannot be kept.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::{Path, PathBuf};

use command::{CommandOutput, finish, surefoot};

const ROBOT: &str = "configs/robots/hubo/robot.toml";

fn prepare(robot: &str, cache: &Path) -> CommandOutput {
    finish(surefoot(&["prepare", robot]).env("XDG_CACHE_HOME", cache).spawn().unwrap())
}

fn files(cache: &Path) -> Vec<PathBuf> {
    fs::read_dir(cache.join("surefoot")).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_preparation_is_kept_read_again_and_made_again_where_it_is_damaged() {
    let cache = tempfile::tempdir().unwrap();
    let first = prepare(ROBOT, cache.path());
    assert_eq!((first.code, first.err.as_str()), (0, ""), "{}", first.out);
    assert!(
        first.out.contains("made in")
            && first.out.contains("reach left")
            && first.out.contains("range right"),
        "{}",
        first.out
    );
    let kept = files(cache.path());
    assert_eq!(kept.len(), 1);
    let sound = fs::read(&kept[0]).unwrap();

    let second = prepare(ROBOT, cache.path());
    assert!(second.code == 0 && second.out.contains("read from"), "{}", second.out);

    let mut damaged = sound.clone();
    damaged[sound.len() / 2] ^= 1;
    fs::write(&kept[0], &damaged).unwrap();
    let third = prepare(ROBOT, cache.path());
    assert!(third.code == 0 && third.out.contains("made in"), "{}", third.out);
    assert!(files(cache.path()) == kept && fs::read(&kept[0]).unwrap() == sound);
}

fn plan(cache: &Path, options: &[&str]) -> CommandOutput {
    let arguments = [&["plan", "configs/scenarios/flat_walk.toml"], options].concat();
    finish(surefoot(&arguments).env("XDG_CACHE_HOME", cache).spawn().unwrap())
}

/// The line of a plan's summary that names its digest.
fn digest(output: &CommandOutput) -> &str {
    output
        .out
        .lines()
        .find(|line| line.contains("digest"))
        .unwrap_or_else(|| panic!("{}{}", output.out, output.err))
}

#[test]
fn planning_prepares_the_robot_and_trusts_no_damaged_or_outdated_file() {
    let cache = tempfile::tempdir().unwrap();
    let first = plan(cache.path(), &["--quiet"]);
    assert_eq!((first.code, first.err.as_str()), (0, ""), "{}", first.out);
    let kept = files(cache.path());
    assert_eq!(kept.len(), 1);
    let sound = fs::read(&kept[0]).unwrap();
    let version = 8;
    for (name, at) in
        [("version", version), ("key", 20), ("contents", sound.len() / 2), ("end", sound.len())]
    {
        let mut damaged = sound.clone();
        match damaged.get_mut(at) {
            Some(byte) => *byte ^= 1,
            None => damaged.truncate(at - 8),
        }
        fs::write(&kept[0], &damaged).unwrap();
        let again = plan(cache.path(), &["--quiet"]);
        assert_eq!((again.code, digest(&again)), (0, digest(&first)), "{name}: {}", again.err);
        assert!(files(cache.path()) == kept && fs::read(&kept[0]).unwrap() == sound, "{name}");
    }
}

#[test]
fn a_walk_needs_no_cache_and_reports_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let output = plan(&file, &[]);
    assert_eq!(output.code, 0, "{}", output.err);
    assert_eq!(
        output.err.lines().filter(|line| line.starts_with("warning: ")).count(),
        1,
        "{}",
        output.err
    );
}

#[test]
fn a_cache_that_cannot_be_written_costs_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let output = prepare(ROBOT, &file);
    assert_eq!(output.code, 0);
    assert!(
        output.err.starts_with("warning: ") && output.err.lines().count() == 1,
        "{}",
        output.err
    );
    assert!(output.out.contains("not kept"), "{}", output.out);
}

#[test]
fn a_pipe_in_the_caches_place_is_replaced_and_not_waited_for() {
    let cache = tempfile::tempdir().unwrap();
    assert_eq!(prepare(ROBOT, cache.path()).code, 0);
    let kept = files(cache.path());
    fs::remove_file(&kept[0]).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&kept[0]).status().unwrap().success());
    let output = prepare(ROBOT, cache.path());
    assert_eq!((output.code, output.err.as_str()), (0, ""), "{}", output.out);
    assert!(fs::metadata(&kept[0]).unwrap().is_file());
}

#[test]
fn a_robot_that_is_not_there_is_bad_input() {
    let output = prepare("nowhere/robot.toml", Path::new("/nonexistent"));
    assert_eq!((output.code, output.out.as_str()), (2, ""));
    assert!(output.err.starts_with("error: ") && output.err.lines().count() == 1, "{}", output.err);
}
