//! Full shared memory and full disks: one line of error, exit code 2, no partial file and no crash.
//!
//! Needs root, to mount small file systems in a private namespace. Skipped otherwise, or failed if
//! `SUREFOOT_REQUIRE_ALL` is set.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped")]
#![allow(clippy::unwrap_used, reason = "a system call that fails unexpectedly fails the test")]

#[path = "common/absent.rs"]
mod absent;

use std::process::{Command, Output};

const SUREFOOT: &str = env!("CARGO_BIN_EXE_surefoot");

/// Whether this process may mount file systems in a private namespace.
fn may_mount() -> bool {
    let mounted = Command::new("unshare")
        .args(["-m", "sh", "-c", "mount -t tmpfs -o size=1m tmpfs /mnt"])
        .output();
    let may = mounted.is_ok_and(|output| output.status.success());
    if !may {
        absent::skip("may not mount");
    }
    may
}

/// Runs a shell command in a private namespace with a tmpfs of a size mounted at `place`.
fn with_tmpfs(size: &str, place: &str, line: &str) -> Output {
    let script = format!("mount -t tmpfs -o mode=1777,size={size} tmpfs {place} && {line}");
    let mut command = Command::new("unshare");
    command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command
        .args(["-m", "sh", "-c", &script])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn full_shared_memory_is_an_error_without_a_crash() {
    if !may_mount() {
        return;
    }
    let mut refused = 0;
    for size in ["64k", "1m", "6m", "9m", "11m", "13m", "16m", "20m"] {
        let line = format!(
            "{SUREFOOT} walk configs/scenarios/flat_walk.toml --quiet; code=$?; ls -A /dev/shm; exit $code"
        );
        let output = with_tmpfs(size, "/dev/shm", &line);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        match output.status.code() {
            Some(0) => assert!(out.contains("walked and accepted"), "{size}: {out}{err}"),
            Some(2) => {
                refused += 1;
                assert_eq!((out.as_str(), err.lines().count()), ("", 1), "{size}: {out}{err}");
                assert!(
                    err.contains("shared memory is full") || err.contains("No space left"),
                    "{size}: {err}"
                );
            }
            code => panic!("{size}: {code:?} {out}{err}"),
        }
    }
    assert!(refused >= 3, "{refused}");
}

#[test]
fn a_full_disk_is_an_error_without_a_partial_file() {
    if !may_mount() {
        return;
    }
    let line = format!(
        "{SUREFOOT} plan configs/scenarios/flat_walk.toml --quiet --export /mnt/plan.json; code=$?; ls -A /mnt; exit $code"
    );
    let output = with_tmpfs("100k", "/mnt", &line);
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(2), "{out}{err}");
    assert!(out.contains("plan found") && !out.contains("surefoot-"), "{out}");
    assert!(err.contains("/mnt/plan.json") && err.lines().count() == 1, "{err}");
}
