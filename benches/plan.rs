//! How long whole plans take: `cargo bench --bench plan [-- SCENARIO..]` plans each scenario with the seeds 1 to 10 and
//! prints a table. Times are of the search alone; robot and world are loaded and compiled before.

#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::disallowed_methods, missing_docs, reason = "a command that times")]

use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use surefoot_planner::prepare;
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scene::load::load_world;

const SCENARIOS: [&str; 4] = ["flat_walk", "stepping_stones", "ibeam_hallway", "ibeam_gap"];
const SEEDS: std::ops::RangeInclusive<u64> = 1..=10;
const STEP: u64 = 20_000;

/// One search.
struct Run {
    seconds: f64,
    ready_seconds: f64,
    work: u64,
    outcome: Outcome,
}

fn plan(scenario: &str, seed: u64) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenarios/{scenario}.toml"));
    let scenario = load_scenario(&path).unwrap().with_seed(seed);
    let (robot, world) = (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let preparation = prepare::make(&robot, &scenario.planner).unwrap();
    let begin = Instant::now();
    let mut planner = Planner::new(&robot, &world, &scenario, preparation, threads).unwrap();
    let ready_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let outcome = loop {
        if let Status::Done(outcome) = planner.step(STEP) {
            break outcome;
        }
    };
    Run { seconds: begin.elapsed().as_secs_f64(), ready_seconds, work: planner.tally().work, outcome }
}

/// The value that a share of the sorted values does not exceed (nearest rank).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let rank = libm::ceil(share * sorted.len() as f64) as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let scenarios: Vec<&str> = if asked.is_empty() { SCENARIOS.into() } else { asked.iter().map(String::as_str).collect() };
    println!(
        "{:<18}{:>7}{:>10}{:>10}{:>10}{:>10}{:>10}{:>12}",
        "scenario", "found", "median s", "mean s", "p95 s", "max s", "ready s", "mean work"
    );
    for scenario in scenarios {
        let runs: Vec<Run> = SEEDS.map(|seed| plan(scenario, seed)).collect();
        let mut seconds: Vec<f64> = runs.iter().map(|run| run.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let found = runs.iter().filter(|run| run.outcome == Outcome::Found).count();
        println!(
            "{scenario:<18}{:>7}{:>10.4}{:>10.4}{:>10.4}{:>10.4}{:>10.4}{:>12.0}",
            format!("{found}/{}", runs.len()),
            quantile(&seconds, 0.5),
            mean(seconds.iter().copied()),
            quantile(&seconds, 0.95),
            quantile(&seconds, 1.0),
            mean(runs.iter().map(|run| run.ready_seconds)),
            mean(runs.iter().map(|run| run.work as f64)),
        );
    }
}
