//! Kills a role of a walk at a chosen call of the system library. The walk must succeed, whichever
//! node, service, segment or connection is left half made.
//!
//! Skipped without a C compiler. All calls:
//! `cargo test --release --test kills_at_calls -- --ignored --nocapture`.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/random.rs"]
mod random;

use std::path::{Path, PathBuf};
use std::process::Command;

use command::{assert_nothing_left, finish, scenario, surefoot};
use random::Random;

/// Walks at most to count the calls of a role.
const COUNTING_WALKS: usize = 3;
/// Killed walks of each role in the short test.
const WALKS: u64 = 8;
/// The seed of the sample of calls.
const SEED: u64 = 43;

/// The compiled library for LD_PRELOAD, in its folder.
struct Library {
    folder: tempfile::TempDir,
}

impl Library {
    fn compile() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/end_at_call.c");
        let compiled = Command::new("cc")
            .args(["-O1", "-shared", "-fPIC", "-o"])
            .arg(folder.path().join("end_at_call.so"))
            .arg(source)
            .arg("-ldl")
            .status();
        match compiled {
            Ok(status) => {
                assert!(status.success(), "the library does not compile");
                Some(Self { folder })
            }
            Err(error) => {
                absent::skip(&format!("no C compiler ({error})"));
                None
            }
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A walk whose process of the role `role` is killed at the call number `call`. Returns whether
    /// it was killed.
    fn walk(&self, role: &str, call: u64) -> bool {
        let mark = self.path("mark");
        let _ = std::fs::remove_dir(&mark);
        let file = scenario("flat_walk");
        let mut walk = surefoot(&["walk", &file, "--quiet", "--threads", "1"]);
        walk.env("LD_PRELOAD", self.path("end_at_call.so"))
            .env("ROLE", role)
            .env("CALL", call.to_string())
            .env("MARK", &mark)
            .env("COUNT", self.path("count"));
        let output = finish(walk.spawn().unwrap());
        assert_eq!(output.code, 0, "{role}, call {call}: {}{}", output.out, output.err);
        assert_nothing_left(output.pid);
        mark.exists()
    }

    /// The number of calls of a role in a walk without a kill.
    fn calls(&self, role: &str) -> u64 {
        let file = self.path("count");
        // A process that its supervisor ends while it writes leaves an empty file.
        let count = || {
            assert!(!self.walk(role, 0));
            std::fs::read_to_string(&file).unwrap().parse().ok()
        };
        (0..COUNTING_WALKS).find_map(|_| count()).expect("a role writes its number of calls")
    }
}

#[test]
fn a_walk_survives_a_kill_at_a_sample_of_the_calls() {
    let Some(library) = Library::compile() else { return };
    let mut random = Random(SEED);
    for role in ["control", "plan"] {
        let calls = library.calls(role);
        let killed = (0..WALKS).filter(|_| library.walk(role, 1 + random.below(calls))).count();
        println!("{role}: {calls} calls, {killed} of {WALKS} walks with a kill");
        assert!(killed > 0);
    }
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn a_walk_survives_a_kill_at_every_call() {
    let Some(library) = Library::compile() else { return };
    for role in ["control", "plan"] {
        let calls = library.calls(role);
        let killed = (1..=calls).filter(|call| library.walk(role, *call)).count();
        println!("{role}: {killed} of {calls} walks with a kill");
    }
}
