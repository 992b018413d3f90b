//! `surefoot prepare` and its cache: kept once, read again, made again where it is damaged, and no trouble where it cannot
//! be kept.

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
    assert!(first.out.contains("made in") && first.out.contains("reach left") && first.out.contains("range right"), "{}", first.out);
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
