//! Plan files: ends, phases that follow each other, chunks that do not fit, and executed walks.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod smooth_swing;

use std::f64::consts::TAU;
use std::path::Path;

use check_robot::*;
use smooth_swing::smooth_swing;
use surefoot_controller_sim::{PlanReport, Problem, check_plan_in};
use surefoot_shared_types::InputError;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Check, Interpolation, PlanChunk, SupportMode, Waypoint};
use surefoot_shared_types::plan_file::write::plan_without_origin;
use surefoot_shared_types::plan_format::blocks::{EndBlock, PhaseBlock, PlanFile};

const ANYWHERE: EndBlock =
    EndBlock::RootRegion { xy: [0.0; 2], radius: 1.0, z_range: None, yaw: None, yaw_tol: None };

/// The plan of a motion in one mode, in one chunk that rests at its end.
fn plan(mode: SupportMode, motion: &[Waypoint]) -> PlanFile {
    let contacts = both_feet();
    let stance = if mode == SupportMode::Left { &contacts[..1] } else { &contacts };
    let mut chunk: Box<PlanChunk> = Box::new(bytemuck::Zeroable::zeroed());
    (chunk.schema, chunk.mode, chunk.flags) = (CHUNK_SCHEMA, mode as u32, FLAG_FIRST | FLAG_LAST);
    chunk.contacts_len = stance.len() as u32;
    chunk.contacts[..stance.len()].copy_from_slice(stance);
    chunk.waypoints_len = motion.len() as u32;
    chunk.waypoints[..motion.len()].copy_from_slice(motion);
    chunk.joints_len = 4;
    chunk.interpolation = Interpolation::Quintic as u64;
    chunk.brake_at = motion[motion.len() - 1].time;
    let ends = [ANYWHERE, ANYWHERE];
    plan_without_origin(&robot(), &world(vec![]), ends, &[*chunk], Path::new("/"))
}

fn problem(plan: &PlanFile) -> Problem {
    let ends = [plan.start.clone(), plan.goal.clone()];
    Problem::of_ends(robot(), world(vec![]), CheckerConfig::default(), ends)
}

fn checked(plan: &PlanFile) -> Result<PlanReport, InputError> {
    check_plan_in(plan, Path::new("/by_hand.json"), &problem(plan))
}

fn violations(plan: &PlanFile) -> Vec<(usize, Check)> {
    let report = checked(plan).unwrap();
    report.violations().map(|found| (found.phase, found.violation.check)).collect()
}

#[test]
fn the_heading_at_the_goal_counts_by_the_shorter_way() {
    let reached = |yaw: f64, yaw_tol: Option<f64>| {
        let goal = EndBlock::RootRegion {
            xy: [0.0; 2],
            radius: 1.0,
            z_range: None,
            yaw: Some(yaw),
            yaw_tol,
        };
        let plan = PlanFile { goal, ..plan(SupportMode::Double, &smooth_swing(0.1, 1.0, 6)) };
        checked(&plan).unwrap().goal.violation.is_none()
    };
    for turn in [0.0, TAU, -TAU] {
        for side in [-1.0, 1.0] {
            assert!(reached(turn + 0.19 * side, None) && !reached(turn + 0.21 * side, None));
            let near = |yaw: f64| reached(turn + yaw * side, Some(0.01));
            assert!(near(0.009) && !near(0.011), "{turn} {side}");
        }
    }
    assert!(!reached(0.5 * TAU, None) && !reached(-0.5 * TAU, None));
}

#[test]
fn a_plan_that_begins_or_ends_in_motion_is_refused() {
    let motion = smooth_swing(0.1, 1.0, 6);
    for part in [&motion[2..], &motion[..5]] {
        let mut plan = plan(SupportMode::Double, part);
        plan.chunks.clear();
        assert_eq!(violations(&plan), [(0, Check::Continuity)]);
    }
}

#[test]
fn a_foot_does_not_wander_from_phase_to_phase() {
    let moved = |steps: [f64; 3]| {
        let mut plan = plan(SupportMode::Double, &smooth_swing(0.1, 1.0, 6));
        let phase = |(index, step): (usize, f64)| {
            let mut phase =
                PhaseBlock { first: 2 * index, last: 2 * index + 2, ..plan.phases[0].clone() };
            phase.contacts[0].sole_pose.xyz[0] += step;
            phase
        };
        plan.phases = steps.into_iter().enumerate().map(phase).collect();
        plan.chunks.clear();
        violations(&plan)
    };
    assert_eq!(moved([0.0, 0.6e-6, 0.6e-6]), []);
    assert_eq!(moved([0.0, 0.6e-6, 1.2e-6]), [(2, Check::Continuity)]);
    assert_eq!(moved([0.0, 1.2e-6, 1.2e-6])[0], (1, Check::Continuity));
}

#[test]
fn where_the_stops_of_a_plan_are_not_known_its_accelerations_keep_the_default() {
    // The shoulder turns by up to 13 rad/s2, 10 being the default.
    let mut plan = plan(SupportMode::Double, &smooth_swing(0.2, 0.3, 6));
    assert_eq!(violations(&plan), []);
    plan.chunks[0].last -= 1;
    assert_eq!(violations(&plan), [(0, Check::Acceleration)]);
    assert!(checked(&plan).unwrap().notes.iter().any(|note| note.contains("was edited")));
    plan.chunks.clear();
    assert!(checked(&plan).unwrap().notes.iter().any(|note| note.contains("names no chunks")));
}

#[test]
fn an_executed_walk_names_no_chunks_and_no_misplaced_feet() {
    let sound = plan(SupportMode::Double, &smooth_swing(0.1, 1.0, 6));
    checked(&sound).unwrap();
    let with_chunks = PlanFile { executed: true, ..sound.clone() };
    assert!(checked(&with_chunks).unwrap_err().to_string().contains("names no chunks"));
    let walk = PlanFile { chunks: Vec::new(), ..with_chunks };
    assert!(checked(&walk).unwrap().is_valid());
    let disturbed = PlanFile { disturb_seed: Some(3), ..walk };
    assert!(checked(&disturbed).unwrap_err().to_string().contains("--disturb 3"));
}
