//! A serving planner and a serving controller, clients that send requests, and a monitor.

#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::process::{Child, Command};

use command::{CommandOutput, finish, run, scenario, surefoot};
use serde_json::Value;
use surefoot_shared_types::instance::instance::Instance;

/// A serving planner and a serving controller.
struct Pair {
    name: String,
    control: Child,
    plan: Child,
}

impl Pair {
    fn start(name: &str) -> Self {
        let name = format!("test-{name}-{}", std::process::id());
        let file = scenario("flat_walk");
        let control =
            surefoot(&["control", &file, "--instance", &name, "--serve"]).spawn().unwrap();
        let plan = surefoot(&["plan", &file, "--instance", &name, "--serve"]).spawn().unwrap();
        while Instance::attach(&name).is_err() {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        Self { name, control, plan }
    }

    fn request(&self, arguments: &[&str]) -> CommandOutput {
        run(&[&["request", "--instance", &self.name], arguments].concat())
    }

    /// Ends both; returns the output of the planner.
    fn end(self) -> String {
        for child in [&self.plan, &self.control] {
            assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
        }
        let (plan, control) = (finish(self.plan), finish(self.control));
        assert_eq!((plan.code, control.code), (143, 0), "{}{}", plan.err, control.err);
        let left = Instance::attach(&self.name).err().map(|error| error.to_string());
        assert!(
            left.is_some_and(|error| error.contains("does not exist")),
            "the instance still exists"
        );
        plan.out
    }
}

#[test]
fn clients_request_one_walk_after_the_other_and_a_monitor_receives_them() {
    let pair = Pair::start("serve");
    let monitor = surefoot(&["monitor", "--instance", &pair.name, "--json", "--seconds", "1000"])
        .spawn()
        .unwrap();
    for (goal, plan) in
        [("1.5,0,0,0", "plan 1.0"), ("2.5,0.2,0,0.5", "plan 2.0"), ("1.2,0,0,0", "plan 3.0")]
    {
        let output = pair.request(&["--goal", goal]);
        assert_eq!(output.code, 0, "{goal}: {}{}", output.out, output.err);
        assert!(output.out.starts_with(&format!("accepted: {plan}")), "{}", output.out);
    }
    let output = pair.request(&["--replan", "--seed", "5"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let output = pair.request(&["--goal", "1.5,0,4,0"]);
    assert!(
        output.code == 2 && output.out.starts_with("goal_invalid"),
        "a goal in the air: {}{}",
        output.out,
        output.err
    );
    let output = pair.request(&["--start", "1.5,0,4,0", "--goal", "1.5,0,0,0"]);
    assert!(
        output.code == 2 && output.out.starts_with("start_invalid"),
        "a start in the air: {}{}",
        output.out,
        output.err
    );
    let output = pair.request(&["--cancel"]);
    assert_eq!(
        (output.code, output.out.starts_with("cancelled")),
        (0, true),
        "{}{}",
        output.out,
        output.err
    );
    assert!(
        Command::new("kill").args(["-INT", &monitor.id().to_string()]).status().unwrap().success()
    );
    let received = finish(monitor);
    let events: Vec<Value> =
        received.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let count = |event: &str| events.iter().filter(|line| line["event"] == event).count();
    assert_eq!(
        (count("planner"), count("controller"), count("refused")),
        (1, 1, 0),
        "{}",
        received.out
    );
    assert!(
        count("finished") >= 3
            && count("plan") >= 3
            && count("summary") >= 1
            && count("request") >= 6,
        "{}",
        received.out
    );
    let planner_output = pair.end();
    for text in [
        "plan 1.0: accepted",
        "the goal is invalid",
        "the start is invalid",
        "no surface is below the sole",
    ] {
        assert!(planner_output.contains(text), "'{text}' is not in: {planner_output}");
    }
}

#[test]
fn after_a_cancel_the_next_walk_starts_at_the_rest_state() {
    let pair = Pair::start("cancel");
    let long =
        surefoot(&["request", "--instance", &pair.name, "--goal", "9.0,0,0,0"]).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(900));
    let cancel = pair.request(&["--cancel"]);
    assert_eq!(cancel.code, 0, "{}{}", cancel.out, cancel.err);
    let long = finish(long);
    assert!(long.code == 2 || long.code == 0, "{}{}", long.out, long.err);
    let output = pair.request(&["--goal", "4.0,0,0,0"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    pair.end();
}

#[test]
fn requests_without_a_planner_end_with_one_line() {
    let output = run(&["request", "--instance", "nobody-is-here", "--goal", "1,0,0,0"]);
    assert_eq!((output.code, output.err.lines().count()), (2, 1), "{}", output.err);
    for wrong in [
        &["--goal", "1,0,0"][..],
        &["--goal", "1,0,0,nan"],
        &["--goal", "1,0,0,0", "--cancel"],
        &["--start", "1,0,0,0"],
        &[],
    ] {
        let output = run(&[&["request", "--instance", "nobody-is-here"], wrong].concat());
        assert_eq!(output.code, 2, "{wrong:?}: {}", output.out);
    }
    let output = run(&["monitor", "--instance", "nobody-is-here"]);
    assert_eq!((output.code, output.err.lines().count()), (2, 1), "{}", output.err);
}
