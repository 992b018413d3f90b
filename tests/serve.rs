//! A serving planner and a serving controller, clients that send requests, and a monitor.

#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command};

use command::{CommandOutput, finish, run, scenario, surefoot};
use serde_json::Value;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

/// A serving planner and a serving controller.
struct Pair {
    name: String,
    control: Child,
    plan: Child,
}

impl Pair {
    fn start(name: &str) -> Self {
        Self::start_at_rate(name, None)
    }

    /// A pair whose robot walks at this rate.
    fn start_at_rate(name: &str, rate: Option<&str>) -> Self {
        let name = format!("test-{name}-{}", std::process::id());
        let file = scenario("flat_walk");
        let mut control = surefoot(&["control", &file, "--instance", &name, "--serve"]);
        let control = control.args(rate.iter().flat_map(|rate| ["--rate", *rate])).spawn().unwrap();
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
        assert_eq!((plan.code, control.code), (0, 0), "{}{}", plan.err, control.err);
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
    for text in [&output.out, &output.err] {
        assert!(text.contains("no surface is below the sole"), "the reason: {text}");
    }
    let output = pair.request(&["--start", "1.5,0,4,0", "--goal", "1.5,0,0,0"]);
    assert!(
        output.code == 2 && output.out.starts_with("start_invalid"),
        "a start in the air: {}{}",
        output.out,
        output.err
    );
    let far = ["--goal", "12000,0,0,0"];
    for arguments in [&far[..], &["--goal", "1,0,0,0", "--stance-width", "200"]] {
        let output = pair.request(arguments);
        let asks = output.err.contains("the request is invalid: goal: out of range: millimetres?");
        assert!(output.code == 2 && asks, "{arguments:?}: {}{}", output.out, output.err);
    }
    for start in [&[][..], &["--start", "0,0,0,0"]] {
        let output = pair.request(&[start, &["--goal", "3000,0,0,0"]].concat());
        let asks = output.out.contains("m from the start: millimetres? positions are in m");
        assert!(output.code == 2 && asks, "{start:?}: {}{}", output.out, output.err);
        assert_eq!(output.err.lines().last().map(|line| line.contains("goal: it is")), Some(true));
    }
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

/// Waits until the robot has executed at least one chunk; returns the observer.
fn wait_until_walking(name: &str) -> Observer {
    let observer = Observer::open(&Instance::attach(name).unwrap()).unwrap();
    while last_walked(&observer) == 0 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    observer
}

/// Chunks that the robot has executed, by the latest feedback; waits for one.
fn last_walked(observer: &Observer) -> u64 {
    let mut walked = None;
    while walked.is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
        while let Some(feedback) = observer.feedback().unwrap() {
            walked = Some(feedback.walked);
        }
    }
    walked.unwrap()
}

#[test]
fn a_cancel_is_answered_when_the_walking_robot_stands() {
    let pair = Pair::start_at_rate("cancel-rate", Some("4"));
    let goal = ["request", "--instance", &pair.name, "--goal", "4,0,0,0"];
    let walk = surefoot(&goal).spawn().unwrap();
    let observer = wait_until_walking(&pair.name);
    let before = last_walked(&observer);
    let cancel = pair.request(&["--cancel"]);
    let at_rest = last_walked(&observer);
    assert!(
        cancel.code == 0 && cancel.out.contains("the robot stands after"),
        "{}{}",
        cancel.out,
        cancel.err
    );
    let walk = finish(walk);
    assert!(
        walk.code == 2 && walk.err.contains("a newer request took its place"),
        "{}{}",
        walk.out,
        walk.err
    );
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert_eq!(last_walked(&observer), at_rest, "the robot stands");
    assert!(at_rest >= before && at_rest < 68, "{at_rest} chunks, {before} before the cancel");
    drop(observer);
    pair.end();
}

#[test]
fn a_request_after_an_interrupted_one_is_answered() {
    let pair = Pair::start_at_rate("interrupted", Some("4"));
    let goal = ["request", "--instance", &pair.name, "--goal", "9,0,0,0"];
    let interrupted = surefoot(&goal).spawn().unwrap();
    drop(wait_until_walking(&pair.name));
    let id = interrupted.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(finish(interrupted).code, 130);
    let output = pair.request(&["--cancel"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    pair.end();
}

#[test]
fn a_planner_that_is_ended_while_it_improves_reports_its_best_plan() {
    let name = format!("test-improve-{}", std::process::id());
    let file = scenario("flat_walk");
    let improve = ["--improve", "1000000000000"];
    let mut plan =
        surefoot(&[&["plan", &file, "--instance", &name, "--serve"], &improve[..]].concat())
            .spawn()
            .unwrap();
    while Instance::attach(&name).is_err() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let goal = ["request", "--instance", &name, "--goal", "1.5,0,0,0"];
    let client = surefoot(&goal).spawn().unwrap();
    let mut lines = BufReader::new(plan.stderr.take().unwrap());
    let mut text = String::new();
    while !text.contains("improving a plan") {
        assert_ne!(lines.read_line(&mut text).unwrap(), 0, "{text}");
    }
    assert!(Command::new("kill").arg(plan.id().to_string()).status().unwrap().success());
    lines.read_to_string(&mut text).unwrap();
    let (plan, client) = (finish(plan), finish(client));
    assert_eq!((plan.code, client.code), (0, 2), "{text}{}", client.err);
    assert!(plan.out.contains("then stopped"), "{}", plan.out);
    assert!(client.err.contains("its best plan, of"), "{}", client.err);
}

#[test]
fn twelve_clients_at_once_each_get_an_end() {
    let pair = Pair::start("twelve");
    let request = |x: usize| {
        let goal = format!("1.{x},0,0,0");
        surefoot(&["request", "--instance", &pair.name, "--goal", &goal]).spawn().unwrap()
    };
    let clients: Vec<Child> = (0..12).map(request).collect();
    let outputs: Vec<CommandOutput> = clients.into_iter().map(finish).collect();
    for output in &outputs {
        let is_served = output.code == 0 && output.out.starts_with("accepted: ");
        let is_replaced = output.code == 2 && output.err.contains("a newer request");
        assert!(is_served || is_replaced, "{} {}{}", output.code, output.out, output.err);
    }
    assert!(outputs.iter().any(|output| output.code == 0), "the last one is served");
    pair.end();
}

#[test]
fn a_second_planner_is_refused_and_the_first_still_serves() {
    let pair = Pair::start("second");
    assert_eq!(pair.request(&["--goal", "1.2,0,0,0"]).code, 0);
    for options in [&["--quiet"][..], &["--serve"]] {
        let file = scenario("flat_walk");
        let second = run(&[&["plan", &file, "--instance", &pair.name], options].concat());
        assert_eq!((second.code, second.err.lines().count()), (2, 1), "{}", second.err);
        assert!(second.err.contains("another planner plans"), "{}", second.err);
    }
    let output = pair.request(&["--goal", "1.5,0,0,0"]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    pair.end();
}

#[test]
fn a_killed_planner_ends_the_request_of_its_client() {
    let Pair { name, mut control, mut plan } = Pair::start_at_rate("killed", Some("1"));
    let goal = ["request", "--instance", &name, "--goal", "4,0,0,0"];
    let client = surefoot(&goal).spawn().unwrap();
    let observer = wait_until_walking(&name);
    plan.kill().unwrap();
    plan.wait().unwrap();
    let output = finish(client);
    assert!(
        output.code == 2 && output.err.contains("the planner that had this request has ended"),
        "{}{}",
        output.out,
        output.err
    );
    control.kill().unwrap();
    control.wait().unwrap();
    drop(observer);
    assert_eq!(Instance::clean_dead().err().map(|error| error.to_string()), None);
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
