//! `surefoot prepare` and its cache: kept once, read again, made again where it is damaged, and no
//! trouble where it cannot be kept.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::{Path, PathBuf};

use command::{Said, finish, surefoot};

const ROBOT: &str = "configs/robots/hubo/robot.toml";

fn prepare(robot: &str, cache: &Path) -> Said {
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

fn plan(cache: &Path, options: &[&str]) -> Said {
    let arguments = [&["plan", "configs/scenarios/flat_walk.toml"], options].concat();
    finish(surefoot(&arguments).env("XDG_CACHE_HOME", cache).spawn().unwrap())
}

/// The line of a plan's summary that names its digest.
fn digest(said: &Said) -> &str {
    said.out
        .lines()
        .find(|line| line.contains("digest"))
        .unwrap_or_else(|| panic!("{}{}", said.out, said.err))
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
fn a_walk_needs_no_cache_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let said = plan(&file, &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(
        said.err.lines().filter(|line| line.starts_with("warning: ")).count(),
        1,
        "{}",
        said.err
    );
}

#[test]
fn a_cache_that_cannot_be_written_costs_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let said = prepare(ROBOT, &file);
    assert_eq!(said.code, 0);
    assert!(said.err.starts_with("warning: ") && said.err.lines().count() == 1, "{}", said.err);
    assert!(said.out.contains("not kept"), "{}", said.out);
}

#[test]
fn a_robot_that_is_not_there_is_bad_input() {
    let said = prepare("nowhere/robot.toml", Path::new("/nonexistent"));
    assert_eq!((said.code, said.out.as_str()), (2, ""));
    assert!(said.err.starts_with("error: ") && said.err.lines().count() == 1, "{}", said.err);
}
