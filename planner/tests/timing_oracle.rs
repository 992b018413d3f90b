//! The fastest profile along a path against that of toppra [Pham, Pham 2018], for limits of joints
//! and for all limits of a walk.
//!
//! Skipped without the Python package toppra; `SUREFOOT_PYTHON` names an interpreter.

#![allow(clippy::print_stdout, reason = "a test prints what it compares")]
#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[path = "../../tests/common/absent.rs"]
mod absent;
mod common;
#[path = "common/smooth_walk.rs"]
mod smooth_walk;
#[path = "common/walk_timing.rs"]
mod walk_timing;

use std::io::Write;
use std::process::{Command, Stdio};

use common::hubo;
use glam::DVec2;
use serde_json::{Value, json};
use smooth_walk::smooth_walk;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::timing::limit::Limit;
use surefoot_planner::timing::limits::Level;
use surefoot_planner::timing::profile::{Node, controllable, fastest};
use surefoot_planner::timing::rate_set::RateSet;
use surefoot_shared_types::config::ExecutionConfig;
use walk_timing::profile_seconds;

/// The largest difference of two durations, as a part of them.
const DIFFERENCE_MAX: f64 = 0.02;
/// Points closer than this are moved apart: toppra's grid has none twice.
const APART: f64 = 1e-6;

/// The duration that toppra finds, s; `None` where it is not installed.
fn toppra_seconds(problem: &Value) -> Option<f64> {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut process = Command::new(python)
        .arg(common::repository().join("planner/tests/common/toppra_seconds.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .ok()?;
    process.stdin.take()?.write_all(problem.to_string().as_bytes()).ok()?;
    let output = process.wait_with_output().unwrap();
    if output.status.code() == Some(9) {
        return None;
    }
    assert!(output.status.success(), "toppra failed");
    Some(String::from_utf8(output.stdout).unwrap().trim().parse().unwrap())
}

fn assert_near(name: &str, ours: f64, problem: &Value) {
    let Some(theirs) = toppra_seconds(problem) else {
        return absent::skip("the Python package toppra is not installed");
    };
    println!("{name}: {ours:.5} s, toppra {theirs:.5} s");
    assert!((ours - theirs).abs() <= DIFFERENCE_MAX * theirs, "{name}: {ours} {theirs}");
}

/// The rates of joints that move as `a sin(b s + c)` within limits of speed and acceleration.
fn joint_rates(waves: &[[f64; 3]], s: f64, speed: f64, acceleration: f64) -> RateSet {
    let mut rates = RateSet::within(1e3, 1e3);
    for [a, b, c] in waves {
        let (sin, cos) = libm::sincos(b * s + c);
        let (first, second) = (a * b * cos, -a * b * b * sin);
        rates.clip(DVec2::new(first * first, 0.0), speed * speed, Limit::PathRate);
        for sign in [-1.0, 1.0] {
            rates.clip(sign * DVec2::new(second, first), acceleration, Limit::PathRate);
        }
    }
    rates
}

#[test]
fn joints_move_as_fast_as_toppra_moves_them() {
    for seed in 1..=5 {
        let mut random = Random::new(seed, Stream::Preparation, 0, 0);
        let waves: Vec<[f64; 3]> = (0..7)
            .map(|_| [random.uniform(0.2, 1.0), random.uniform(0.5, 3.0), random.uniform(0.0, 6.0)])
            .collect();
        let (speed, acceleration) = (random.uniform(0.5, 3.0), random.uniform(2.0, 8.0));
        let grid: Vec<f64> = (0..=400).map(|at| 0.01 * f64::from(at)).collect();
        let node = |(at, position): (usize, &f64)| Node {
            position: *position,
            rests: at == 0 || at + 1 == grid.len(),
            rates: joint_rates(&waves, *position, speed, acceleration),
            part: 1.0,
            factor: 1.0,
            level: Level::Full,
            balance: Default::default(),
            inner: Default::default(),
        };
        let nodes: Vec<Node> = grid.iter().enumerate().map(node).collect();
        let (mut ceilings, mut squares) = (vec![0.0; nodes.len()], vec![0.0; nodes.len()]);
        controllable(&nodes, &mut ceilings);
        assert!(fastest(&nodes, &ceilings, &mut squares));
        let states: Vec<(f64, f64)> = grid.iter().copied().zip(squares).collect();
        let problem =
            json!({ "grid": grid, "waves": waves, "speed": speed, "acceleration": acceleration });
        assert_near(&format!("joints {seed}"), profile_seconds(&states), &problem);
    }
}

#[test]
fn a_walk_is_as_fast_as_toppra_makes_it_within_the_same_limits() {
    let model = hubo();
    let walk = smooth_walk(&model, 4, 0.12);
    let mut timing = walk.timing(&model, &ExecutionConfig::default());
    assert!(walk.solve(&mut timing));
    let (mut grid, mut all_sides, mut states) = (Vec::new(), Vec::new(), Vec::new());
    for (node, square) in timing.nodes() {
        let before = grid.last().map_or(f64::NEG_INFINITY, |last: &f64| last + APART);
        grid.push(node.position.max(before));
        let rates = node.rates.scaled(node.factor);
        let sides = rates.sides().map(|(normal, offset, _)| [normal.x, normal.y, offset]);
        all_sides.push(sides.collect::<Vec<_>>());
        states.push((node.position, square));
    }
    let problem = json!({ "grid": grid, "sides": all_sides });
    assert_near("walk", profile_seconds(&states), &problem);
}
