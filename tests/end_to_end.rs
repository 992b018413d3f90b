//! Whole walks of the shipped scenarios: two processes over shared memory.

#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;

use command::{assert_nothing_left, run, scenario};
use serde_json::Value;

/// A successful walk with its output.
struct Walk {
    folder: tempfile::TempDir,
    report: Value,
    out: String,
    err: String,
}

impl Walk {
    fn of(name: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |file: &str| folder.path().join(file).to_str().unwrap().to_owned();
        let (file, plan, json) = (scenario(name), path("plan.json"), path("report.json"));
        let output = run(&[&["walk", &file, "--export", &plan, "--json", &json], more].concat());
        assert_eq!(output.code, 0, "{name}: {}{}", output.out, output.err);
        assert_nothing_left(output.pid);
        let report = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
        Self { folder, report, out: output.out, err: output.err }
    }

    fn path(&self, file: &str) -> String {
        self.folder.path().join(file).to_str().unwrap().to_owned()
    }

    /// A copy of the plan with one change.
    fn damaged(&self, change: impl FnOnce(&mut Value)) -> String {
        let mut plan: Value =
            serde_json::from_slice(&fs::read(self.path("plan.json")).unwrap()).unwrap();
        change(&mut plan);
        fs::write(self.path("damaged.json"), plan.to_string()).unwrap();
        self.path("damaged.json")
    }
}

fn count(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is not a count"))
}

fn assert_complete(name: &str, report: &Value) {
    assert_eq!((&report["outcome"], &report["bound"]), (&"accepted".into(), &Value::Null));
    assert_eq!(
        (&report["scenario"], &report["robot"], &report["world"]),
        (&name.into(), &"hubo".into(), &name.into())
    );
    assert_eq!(report["digest"].as_str().unwrap().len(), 64);
    assert_eq!(report["refusal"], Value::Null);
    for field in ["seed", "threads", "work", "steps", "waypoints", "arena_bytes"] {
        assert!(count(&report[field]) > 0, "{field}");
    }
    assert!(report["allocations_after_ready"].is_u64());
    for field in ["ready_seconds", "plan_seconds", "check_seconds"] {
        assert!(report[field].as_f64().unwrap() > 0.0, "{field}");
    }
    for check in ["limits", "contact", "balance", "collision", "self_collision", "torque"] {
        assert!(report["margins"][check].is_f64(), "{check}: {}", report["margins"]);
    }
    let chunks = &report["chunks"];
    assert!(count(&chunks["sent"]) > 0);
    assert_eq!(chunks["sent"], chunks["accepted"]);
    assert_eq!((count(&chunks["refused"]), count(&chunks["lost"])), (0, 0));
    assert!(chunks["duplicated"].is_u64());
}

fn walks(name: &str) {
    let walk = Walk::of(name, &[]);
    assert_complete(name, &walk.report);
    for expected in ["walked and accepted", "digest", "sent", "margins"] {
        assert!(walk.out.contains(expected), "'{expected}' is not in: {}", walk.out);
    }
    assert!(walk.err.contains("planner ready"), "no progress: {}", walk.err);
    let check = run(&["check", &walk.path("plan.json")]);
    assert_eq!(check.code, 0, "{}{}", check.out, check.err);
    assert!(check.out.ends_with("accepted\n"), "{}", check.out);
}

#[test]
fn flat_walk() {
    walks("flat_walk");
}

#[test]
fn stepping_stones() {
    walks("stepping_stones");
}

#[test]
fn ibeam_hallway() {
    walks("ibeam_hallway");
}

#[test]
fn ibeam_gap() {
    walks("ibeam_gap");
}

#[test]
fn an_impossible_walk_names_what_ended_it() {
    for name in ["no_way_wall", "no_way_ceiling", "no_way_island", "no_way_slope"] {
        let folder = tempfile::tempdir().unwrap();
        let [plan, json, picture] =
            ["plan.json", "report.json", "walk.png"].map(|file| folder.path().join(file));
        let texts = [&plan, &json, &picture].map(|path| path.to_str().unwrap());
        let output = run(&[
            "walk",
            &scenario(name),
            "--quiet",
            "--export",
            texts[0],
            "--json",
            texts[1],
            "--picture",
            texts[2],
        ]);
        assert_eq!(output.code, 3, "{name}: {}{}", output.out, output.err);
        let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
        if name == "no_way_ceiling" {
            assert_bound_and_bottleneck(&output.out, &report);
        } else {
            assert_eq!(report["outcome"], "impossible", "{report}");
            assert!(report["bound"].is_null(), "{report}");
            assert!(output.out.contains(": no plan is possible: "), "{name}: {}", output.out);
        }
        assert!(!plan.exists(), "{name}: a plan exists");
        assert!(picture.exists(), "{name}: no picture of the search");
        assert_eq!(count(&report["chunks"]["sent"]), 0);
        assert_eq!(output.err, "", "{name}: output in spite of --quiet");
        assert_nothing_left(output.pid);
    }
}

/// The report and the summary name the bound that ended a search and where most sequences failed.
fn assert_bound_and_bottleneck(out: &str, report: &Value) {
    let bound = report["bound"].as_str().unwrap_or_else(|| panic!("no bound in {report}"));
    assert!(out.contains(&format!("planner.{bound}")), "'{bound}' is not in: {out}");
    let failures = report["diagnosis"]["bottleneck"]["failures"].as_u64();
    assert!(
        failures > Some(0) && out.contains("\n  bottleneck "),
        "no bottleneck in {report}: {out}"
    );
}

#[test]
fn a_ceiling_over_the_route_is_reported_as_the_bottleneck() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("report.json");
    let output =
        run(&["plan", &scenario("no_way_ceiling"), "--quiet", "--json", json.to_str().unwrap()]);
    assert_eq!(output.code, 3, "{}{}", output.out, output.err);
    let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    let diagnosis = &report["diagnosis"];
    let x = diagnosis["bottleneck"]["xyz"][0].as_f64().unwrap();
    assert!((1.6..=4.4).contains(&x), "the ceiling covers x = 2 to 4: {diagnosis}");
    let most = diagnosis["rejections"]
        .as_object()
        .unwrap()
        .iter()
        .max_by_key(|(_, count)| count.as_u64())
        .unwrap();
    assert_eq!(most.0, "collision", "{diagnosis}");
    let found = run(&["plan", &scenario("flat_walk"), "--quiet", "--json", json.to_str().unwrap()]);
    assert!(found.code == 0 && !found.out.contains("bottleneck"), "{}", found.out);
    let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    assert!(report["diagnosis"].is_null(), "{report}");
}

#[test]
fn a_damaged_plan_is_refused_with_its_location() {
    let walk = Walk::of("flat_walk", &["--quiet", "--motion", "quasi_static"]);
    let turned = walk.damaged(|plan| {
        let names = plan["joint_names"].as_array().unwrap();
        let knees: Vec<usize> = (0..names.len())
            .filter(|&joint| names[joint].as_str().unwrap().contains("knee"))
            .collect();
        assert_eq!(knees.len(), 2);
        let middle = plan["waypoints"].as_array().unwrap().len() / 2;
        for knee in knees {
            let angle = &mut plan["waypoints"][middle]["q"][knee];
            *angle = (angle.as_f64().unwrap() + 0.05).into();
        }
    });
    let output = run(&["check", &turned]);
    assert_eq!(output.code, 4, "{}{}", output.out, output.err);
    assert!(
        output
            .out
            .lines()
            .any(|line| line.starts_with("contact") && line.contains("VIOLATED in phase")),
        "{}",
        output.out
    );

    let moved = walk.damaged(|plan| {
        let phase = plan["phases"].as_array().unwrap().len() / 2;
        let x = &mut plan["phases"][phase]["contacts"][0]["sole_pose"]["xyz"][0];
        *x = (x.as_f64().unwrap() + 0.01).into();
    });
    let output = run(&["check", &moved, "--json"]);
    assert_eq!(output.code, 4, "{}{}", output.out, output.err);
    let report: Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(report["outcome"], "refused");
    let contact = report["checks"]
        .as_array()
        .unwrap()
        .iter()
        .find(|line| line["check"] == "contact")
        .unwrap();
    assert!(contact["violation"]["detail"].is_string(), "{report}");
}

#[test]
fn the_plan_is_the_same_with_any_number_of_threads_and_with_or_without_a_controller() {
    let walked = Walk::of("stepping_stones", &["--quiet", "--threads", "1", "--seed", "3"]);
    assert_eq!((count(&walked.report["seed"]), count(&walked.report["threads"])), (3, 1));
    for threads in ["1", "2", "4"] {
        let json = walked.path("plan_only.json");
        let output = run(&[
            "plan",
            &scenario("stepping_stones"),
            "--quiet",
            "--seed",
            "3",
            "--threads",
            threads,
            "--json",
            &json,
        ]);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
        assert_eq!(report["outcome"], "found");
        assert_eq!(report["digest"], walked.report["digest"], "{threads} threads");
        assert_eq!(report["work"], walked.report["work"], "{threads} threads");
    }
}

#[test]
fn a_picture_of_the_walk_is_drawn_without_an_export() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("walk.png");
    let output =
        run(&["walk", &scenario("flat_walk"), "--quiet", "--picture", picture.to_str().unwrap()]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert_eq!(&fs::read(&picture).unwrap()[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
