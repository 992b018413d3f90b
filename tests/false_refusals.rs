//! The checker refuses no plan of the planner's: plans of many scenarios and seeds, exported and
//! checked as a user would.
//!
//! `cargo test --release --test false_refusals -- --ignored --nocapture` makes 2,000 plans.
//! `SUREFOOT_PLANS=N` makes N, `SUREFOOT_SCENARIOS=DIR:DIR` takes the scenarios in these folders,
//! of other robots for example, and `SUREFOOT_PLANS_KEPT=DIR` keeps the refused plans there, and
//! every 33rd plan for the independent checker.

#![allow(clippy::print_stdout, reason = "a test prints its results")]
#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::{Path, PathBuf};

use command::{run, scenario};

/// Scenarios that every seed solves within seconds.
const SCENARIOS: [&str; 12] = [
    "flat_walk",
    "stepping_stones",
    "ibeam_hallway",
    "ibeam_gap",
    "stairs",
    "beam",
    "monkey_bars",
    "checkers",
    "stairs_bauzil",
    "pass_under",
    "cinder_blocks",
    "spiral_steps",
];
/// One of so many plans is kept for the independent judge.
const KEPT_EVERY: usize = 33;

/// The files of the scenarios: those of `SUREFOOT_SCENARIOS`, else [`SCENARIOS`].
fn scenario_files() -> Vec<String> {
    let Some(folders) = std::env::var_os("SUREFOOT_SCENARIOS") else {
        return SCENARIOS.map(scenario).to_vec();
    };
    let entries = std::env::split_paths(&folders).flat_map(|folder| fs::read_dir(folder).unwrap());
    let paths = entries.map(|entry| entry.unwrap().path().to_str().unwrap().to_owned());
    let mut files: Vec<String> = paths.filter(|path| path.ends_with(".toml")).collect();
    files.sort();
    files
}

/// Makes a plan and checks it; whether it was found and, if so, what the checker refused.
fn try_one(scenario: &str, seed: usize, plan: &Path) -> Option<Result<(), String>> {
    let path = plan.to_str().unwrap();
    let planned = run(&[
        "plan",
        scenario,
        "--seed",
        &seed.to_string(),
        "--threads",
        "1",
        "--quiet",
        "--export",
        path,
    ]);
    if planned.code == 3 {
        return None;
    }
    assert_eq!(planned.code, 0, "{scenario} {seed}: {}{}", planned.out, planned.err);
    let checked = run(&["check", path]);
    Some(if checked.code == 0 { Ok(()) } else { Err(format!("{}{}", checked.out, checked.err)) })
}

fn make_and_check(count: usize) {
    let folder = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("SUREFOOT_PLANS_KEPT").map(PathBuf::from);
    let (mut found, mut refusals) = (0, Vec::new());
    let scenarios = scenario_files();
    for index in 0.. {
        if found == count {
            break;
        }
        let (name, seed) = (&scenarios[index % scenarios.len()], 1 + index / scenarios.len());
        let plan = folder.path().join(format!("{}-{seed}.json", index % scenarios.len()));
        let Some(checked) = try_one(name, seed, &plan) else {
            println!("{name} {seed}: no plan");
            continue;
        };
        found += 1;
        if let Some(kept) = kept.as_ref().filter(|_| checked.is_err() || found % KEPT_EVERY == 0) {
            fs::copy(&plan, kept.join(plan.file_name().unwrap())).unwrap();
        }
        if let Err(refusal) = checked {
            println!("{name} {seed}: {refusal}");
            refusals.push(format!("{name} {seed}"));
        }
        fs::remove_file(&plan).unwrap();
        assert!(index < 3 * count + 100, "most searches find nothing");
    }
    println!("{found} plans, {} refused", refusals.len());
    assert!(refusals.is_empty(), "{refusals:?}");
}

#[test]
fn a_few_plans_pass_the_check() {
    make_and_check(6);
}

#[test]
#[ignore = "takes an hour; run it by command"]
fn two_thousand_plans_pass_the_check() {
    make_and_check(
        std::env::var("SUREFOOT_PLANS").ok().and_then(|text| text.parse().ok()).unwrap_or(2_000),
    );
}
