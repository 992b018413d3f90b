//! Another user of the machine can neither read, nor write, nor stop, nor enter a running pair.
//!
//! Needs root, to become somebody else; says so and skips otherwise, or fails where
//! `SUREFOOT_REQUIRE_ALL` is set.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a test ends where a system call does not do its part")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command};

use command::{finish, scenario, surefoot};
use surefoot_shared_types::instance::instance::Instance;

/// `nobody`.
const STRANGER: u32 = 65_534;

/// Whether this process may become somebody else.
fn is_root() -> bool {
    // SAFETY: geteuid has no preconditions and cannot fail.
    let root = unsafe { libc::geteuid() } == 0;
    if !root {
        absent::skip("not root");
    }
    root
}

/// Runs a shell line as a stranger; answers its exit code.
fn as_stranger(line: &str) -> i32 {
    Command::new("sh")
        .args(["-c", line])
        .uid(STRANGER)
        .gid(STRANGER)
        .status()
        .unwrap()
        .code()
        .unwrap_or(-1)
}

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

    /// Everything that it put into shared memory: folders, files, segments.
    fn things(&self) -> Vec<PathBuf> {
        let segments = fs::read_dir("/dev/shm").unwrap().flatten().map(|entry| entry.path());
        let prefix = self.instance.segment_prefix().to_owned();
        let mut things: Vec<PathBuf> = segments
            .filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(&prefix))
            .collect();
        things.push(self.instance.root().to_owned());
        things.push(self.instance.root().join("robot"));
        things.push(self.instance.root().join("lock"));
        things
    }
}

#[test]
fn a_stranger_can_neither_read_nor_write_nor_remove_nor_stop() {
    if !is_root() {
        return;
    }
    let pair = Pair::start("stranger");
    let things = pair.things();
    assert!(things.len() >= 5, "{things:?}");
    for thing in &things {
        let path = thing.display();
        assert_ne!(
            as_stranger(&format!(
                "cat '{path}' >/dev/null 2>&1 || ls '{path}' >/dev/null 2>&1 && test -d '{path}'"
            )),
            0,
            "{path} read"
        );
        assert_ne!(
            as_stranger(&format!("(printf x >> '{path}') 2>/dev/null")),
            0,
            "{path} written"
        );
        assert_ne!(as_stranger(&format!("rm -rf '{path}' 2>/dev/null")), 0, "{path} removed");
        assert!(thing.exists());
    }
    assert_ne!(as_stranger(&format!("kill -9 {} 2>/dev/null", pair.control.id())), 0, "stopped");
    let Pair { control, instance } = pair;
    let walked =
        command::run(&["plan", &scenario("flat_walk"), "--quiet", "--instance", instance.name()]);
    drop(instance);
    let output = finish(control);
    assert_eq!((walked.code, output.code), (0, 0), "{}{}", walked.err, output.err);
}

#[test]
fn a_folder_that_a_stranger_made_first_is_refused() {
    if !is_root() {
        return;
    }
    let base = tempfile::Builder::new().prefix("sf-squat").tempdir_in("/dev/shm").unwrap();
    let not_private = base.path().join("base");
    fs::create_dir(&not_private).unwrap();
    std::os::unix::fs::chown(&not_private, Some(STRANGER), Some(STRANGER)).unwrap();
    let error = Instance::create_in(&not_private, "walk").unwrap_err();
    assert!(error.to_string().contains("belongs to user 65534"), "{error}");
    assert_eq!(fs::read_dir(&not_private).unwrap().count(), 0);
}
