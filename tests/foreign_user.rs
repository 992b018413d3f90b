//! Another user of the machine cannot read, write, remove or stop a running planner and controller.
//!
//! Needs root, to run commands as another user. Skipped otherwise, or failed if
//! `SUREFOOT_REQUIRE_ALL` is set.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a system call that fails unexpectedly fails the test")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Output};

use command::{finish, role, scenario, surefoot};
use surefoot_shared_types::base::user::effective_uid;
use surefoot_shared_types::instance::instance::Instance;

/// The user id of `nobody`.
const OTHER_USER: u32 = 65_534;

/// Whether this process can run commands as another user.
fn is_root() -> bool {
    let root = effective_uid() == 0;
    if !root {
        absent::skip("not root");
    }
    root
}

/// Runs a shell command as another user; returns its exit code.
fn as_other_user(line: &str) -> i32 {
    Command::new("sh")
        .args(["-c", line])
        .uid(OTHER_USER)
        .gid(OTHER_USER)
        .status()
        .unwrap()
        .code()
        .unwrap_or(-1)
}

/// A controller and a handle on its instance.
struct Pair {
    control: Child,
    instance: Instance,
}

impl Pair {
    fn start(name: &str) -> Self {
        let name = format!("test-{name}-{}", std::process::id());
        let mut control =
            surefoot(&["control", &scenario("flat_walk"), "--instance", &name]).spawn().unwrap();
        while control.try_wait().unwrap().is_none() {
            if let Ok(instance) = Instance::attach(&name)
                && instance.root().join("robot").exists()
            {
                return Self { control, instance };
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("{}", finish(control).err);
    }

    /// Its folders, files and segments in shared memory.
    fn paths(&self) -> Vec<PathBuf> {
        let segments = fs::read_dir("/dev/shm").unwrap().flatten().map(|entry| entry.path());
        let prefix = self.instance.segment_prefix().to_owned();
        let mut paths: Vec<PathBuf> = segments
            .filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(&prefix))
            .collect();
        paths.push(self.instance.root().to_owned());
        paths.push(self.instance.root().join("robot"));
        paths.push(self.instance.root().join("lock"));
        paths
    }
}

#[test]
fn another_user_cannot_read_write_remove_or_stop() {
    if !is_root() {
        return;
    }
    let pair = Pair::start("other-user");
    let paths = pair.paths();
    assert!(paths.len() >= 5, "{paths:?}");
    for path in &paths {
        let shown = path.display();
        assert_ne!(
            as_other_user(&format!(
                "cat '{shown}' >/dev/null 2>&1 || ls '{shown}' >/dev/null 2>&1 && test -d '{shown}'"
            )),
            0,
            "{shown} read"
        );
        assert_ne!(
            as_other_user(&format!("(printf x >> '{shown}') 2>/dev/null")),
            0,
            "{shown} written"
        );
        assert_ne!(as_other_user(&format!("rm -rf '{shown}' 2>/dev/null")), 0, "{shown} removed");
        assert!(path.exists());
    }
    assert_ne!(as_other_user(&format!("kill -9 {} 2>/dev/null", pair.control.id())), 0, "stopped");
    let Pair { control, instance } = pair;
    let walked =
        command::run(&["plan", &scenario("flat_walk"), "--quiet", "--instance", instance.name()]);
    drop(instance);
    let output = finish(control);
    assert_eq!((walked.code, output.code), (0, 0), "{}{}", walked.err, output.err);
}

/// Runs a shell script in a private namespace with an empty `/dev/shm`; `None` if that is not
/// permitted. `$SUREFOOT` is the command; `nobody LINE` runs a line as another user.
fn in_private_memory(script: &str) -> Option<Output> {
    let prelude = format!(
        "mount -t tmpfs -o mode=1777,size=256m tmpfs /dev/shm || exit 9; \
         nobody() {{ setpriv --reuid {OTHER_USER} --regid {OTHER_USER} --clear-groups \
         sh -c \"$1\"; }}; "
    );
    let output = Command::new("unshare")
        .args(["-m", "sh", "-c", &(prelude + script)])
        .env("SUREFOOT", env!("CARGO_BIN_EXE_surefoot"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    match output {
        Ok(output) if output.status.code() != Some(9) => Some(output),
        _ => {
            absent::skip("may not mount");
            None
        }
    }
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

#[test]
fn another_user_who_takes_the_folders_name_stops_no_walk() {
    if !is_root() {
        return;
    }
    let script = format!(
        "nobody 'mkdir -m 700 /dev/shm/surefoot-0; mkdir /dev/shm/surefoot-0-0123456789abcdef'; \
         $SUREFOOT walk {} --quiet; code=$?; ls -A /dev/shm; exit $code",
        scenario("flat_walk")
    );
    let Some(output) = in_private_memory(&script) else { return };
    let text = text(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    let left: Vec<&str> = text.lines().filter(|line| line.starts_with("surefoot-")).collect();
    assert_eq!(left, ["surefoot-0", "surefoot-0-0123456789abcdef"], "{text}");
}

#[test]
fn files_that_another_user_puts_among_the_segments_stop_no_walk() {
    if !is_root() {
        return;
    }
    let pair = Pair::start("among");
    let prefix = pair.instance.segment_prefix().to_owned();
    let made = as_other_user(&format!(
        "cd /dev/shm; : > {prefix}a; mkfifo {prefix}b; mkdir {prefix}c; ln -s / {prefix}d; \
         : > {prefix}e.connection; chmod 200 {prefix}e.connection"
    ));
    assert_eq!(made, 0);
    let Pair { control, instance } = pair;
    let walked =
        command::run(&["plan", &scenario("flat_walk"), "--quiet", "--instance", instance.name()]);
    drop(instance);
    let output = finish(control);
    let mut left = 0;
    for name in ["a", "b", "c", "d", "e.connection"] {
        let path = PathBuf::from(format!("/dev/shm/{prefix}{name}"));
        left += usize::from(path.symlink_metadata().is_ok());
        let _ = if name == "c" { fs::remove_dir(&path) } else { fs::remove_file(&path) };
    }
    assert_eq!((walked.code, output.code), (0, 0), "{}{}", walked.err, output.err);
    assert_eq!(left, 5, "the files of another user are left alone");
}

/// The names of the connections of a walk.
fn connections(walk: &Child) -> Vec<String> {
    let segment = format!("-walk-{}.", walk.id());
    let entries = fs::read_dir("/dev/shm").unwrap().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| name.contains(&segment) && name.ends_with(".connection")).collect()
}

#[test]
fn long_names_of_another_user_stop_no_walk_whose_controller_is_killed() {
    if !is_root() {
        return;
    }
    let mut walk =
        surefoot(&["walk", &scenario("flat_walk"), "--quiet", "--rate", "10"]).spawn().unwrap();
    let mut known = Vec::new();
    while known.len() < 2 {
        assert!(walk.try_wait().unwrap().is_none(), "it ended before it was attacked");
        std::thread::sleep(std::time::Duration::from_millis(20));
        known = connections(&walk);
    }
    let long: Vec<String> = known
        .iter()
        .map(|name| format!("/dev/shm/{name}{}.connection", ".x".repeat((240 - name.len()) / 2)))
        .collect();
    assert_eq!(as_other_user(&format!("touch {}", long.join(" "))), 0);
    let controller = role(walk.id(), "control").unwrap().to_string();
    assert!(Command::new("kill").args(["-KILL", &controller]).status().unwrap().success());
    let output = finish(walk);
    let left = long.iter().filter(|path| fs::remove_file(path).is_ok()).count();
    assert_eq!(output.code, 0, "{}", output.err);
    assert!(!output.err.contains("panicked"), "{}", output.err);
    assert_eq!(left, long.len(), "the files of another user are left alone");
}

#[test]
fn a_folder_of_another_user_is_refused() {
    if !is_root() {
        return;
    }
    let base = tempfile::Builder::new().prefix("sf-squat").tempdir_in("/dev/shm").unwrap();
    let not_private = base.path().join("base");
    fs::create_dir(&not_private).unwrap();
    std::os::unix::fs::chown(&not_private, Some(OTHER_USER), Some(OTHER_USER)).unwrap();
    let error = Instance::create_in(&not_private, "walk").unwrap_err();
    assert!(error.to_string().contains("belongs to user 65534"), "{error}");
    assert_eq!(fs::read_dir(&not_private).unwrap().count(), 0);
}
