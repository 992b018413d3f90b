//! The two processes of a walk: started by hand, ended by signals, killed.

#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command};

use command::{assert_nothing_left, finish, role, run, scenario, surefoot};
use serde_json::Value;
use surefoot_shared_types::instance::instance::Instance;

/// An instance name of this test process.
fn instance(name: &str) -> String {
    format!("test-{name}-{}", std::process::id())
}

/// A walk with a practically unlimited search.
struct EndlessWalk {
    folder: tempfile::TempDir,
    child: Child,
    err: BufReader<std::process::ChildStderr>,
}

impl EndlessWalk {
    /// Starts it and waits until its planner searches.
    fn start(more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let configs = format!("\"{}/configs/", env!("CARGO_MANIFEST_DIR"));
        let text = fs::read_to_string(scenario("no_way_ceiling")).unwrap();
        let text = text
            .replace("\"../", &configs)
            .replace("work_max = 30_000", "work_max = 1_000_000_000_000");
        let file = folder.path().join("endless.toml");
        fs::write(&file, text).unwrap();
        let report = folder.path().join("report.json");
        let walk = ["walk", file.to_str().unwrap(), "--json", report.to_str().unwrap()];
        let mut child = surefoot(&[&walk, more].concat()).spawn().unwrap();
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        err.read_line(&mut line).unwrap();
        assert!(line.starts_with("planner ready"), "{line}");
        Self { folder, child, err }
    }

    /// The process of a role, identified by its subcommand.
    fn role(&self, subcommand: &str) -> String {
        role(self.child.id(), subcommand).unwrap().to_string()
    }

    /// Its exit code, the rest of its stderr, and its folder.
    fn end(mut self) -> (i32, String, tempfile::TempDir) {
        let mut rest = String::new();
        self.err.read_to_string(&mut rest).unwrap();
        let output = finish(self.child);
        assert_nothing_left(output.pid);
        (output.code, rest, self.folder)
    }
}

fn kill(signal: &str, pid: &str) {
    assert!(Command::new("kill").args([signal, pid]).status().unwrap().success());
}

fn is_alive(pid: &str) -> bool {
    fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| !stat.contains(") Z "))
}

/// Waits until a process has ended, at most 5 s.
fn wait_for_end(pid: &str) {
    for _ in 0..1000 {
        if !is_alive(pid) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("process {pid} still runs");
}

#[test]
fn signals_end_both_processes_and_clean_up() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let walk = EndlessWalk::start(&[]);
        let (planner, controller) = (walk.role("plan"), walk.role("control"));
        kill(signal, &walk.child.id().to_string());
        let (ended, err, folder) = walk.end();
        assert_eq!(ended, code, "{err}");
        assert!(!is_alive(&planner) && !is_alive(&controller), "an orphan after {signal}");
        let report: Value =
            serde_json::from_slice(&fs::read(folder.path().join("report.json")).unwrap()).unwrap();
        assert_eq!(report["outcome"], "interrupted");
    }
}

#[test]
fn a_role_that_is_killed_too_often_is_named_and_the_other_one_ended() {
    for (subcommand, name, other) in
        [("plan", "planner", "control"), ("control", "controller", "plan")]
    {
        let walk = EndlessWalk::start(&["--restarts-max", "0"]);
        let survivor = walk.role(other);
        kill("-KILL", &walk.role(subcommand));
        let (code, err, folder) = walk.end();
        assert_eq!(code, 2, "{err}");
        assert_eq!(err.lines().count(), 1, "{err}");
        assert!(
            err.contains(&format!("the {name} process ended unexpectedly"))
                && err.contains("SIGKILL"),
            "{err}"
        );
        assert!(!is_alive(&survivor), "the {other} process still runs");
        let report: Value =
            serde_json::from_slice(&fs::read(folder.path().join("report.json")).unwrap()).unwrap();
        assert_eq!(report["outcome"], format!("{name}_failed"));
    }
}

#[test]
fn the_roles_do_not_outlive_a_killed_supervisor() {
    let walk = EndlessWalk::start(&[]);
    let roles = [walk.role("plan"), walk.role("control")];
    kill("-KILL", &walk.child.id().to_string());
    let EndlessWalk { mut child, mut err, folder: _folder } = walk;
    child.wait().unwrap();
    // The roles share the supervisor's stderr, which ends with the last of them.
    err.read_to_string(&mut String::new()).unwrap();
    roles.iter().for_each(|role| wait_for_end(role));
    // The last process cleans up. If both end at the same time, the next start does.
    Instance::clean_dead().unwrap();
    assert_nothing_left(child.id());
}

#[test]
fn the_roles_find_each_other_when_started_by_hand() {
    let name = instance("hand");
    let file = scenario("flat_walk");
    let control = surefoot(&["control", &file, "--instance", &name]).spawn().unwrap();
    let plan = run(&["plan", &file, "--quiet", "--instance", &name]);
    let control = finish(control);
    assert_eq!(
        (plan.code, control.code),
        (0, 0),
        "{}{}{}{}",
        plan.out,
        plan.err,
        control.out,
        control.err
    );
    assert!(plan.out.contains("walked and accepted"), "{}", plan.out);
    assert!(control.out.contains("chunks walked and accepted"), "{}", control.out);
}

#[test]
fn both_processes_report_the_refusal_of_a_plan_of_another_seed() {
    let name = instance("seed");
    let file = scenario("flat_walk");
    let control =
        surefoot(&["control", &file, "--instance", &name, "--seed", "2"]).spawn().unwrap();
    let plan = run(&["plan", &file, "--quiet", "--instance", &name, "--seed", "3"]);
    let control = finish(control);
    assert_eq!(
        (plan.code, control.code),
        (4, 4),
        "{}{}{}{}",
        plan.out,
        plan.err,
        control.out,
        control.err
    );
    assert!(plan.out.contains("refused") && plan.out.contains("config"), "{}", plan.out);
    assert!(
        control.out.contains("refused: config at waypoint 0 of chunk 0: made for another scenario"),
        "{}",
        control.out
    );
}
