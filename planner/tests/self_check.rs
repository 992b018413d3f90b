//! The planner's own check of a finished plan.

#![allow(clippy::unwrap_used, reason = "a test ends where a plan is not found")]

mod common;

use common::{Case, WALKS, run};
use surefoot_planner::Outcome;
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::plan::self_check::{SelfCheckError, self_check};

#[test]
fn every_plan_passes_its_self_check() {
    for name in WALKS {
        let mut planner = Case::shipped(name).planner(1);
        assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "{name}");
        let done = self_check(planner.constraints(), planner.chunks()).unwrap();
        let waypoints: u64 =
            planner.chunks().iter().map(|chunk| u64::from(chunk.waypoints_len)).sum();
        assert_eq!(done.waypoints, waypoints, "{name}");
        assert!(
            done.between >= planner.waypoints() - 1,
            "{name}: something is checked between any two waypoints"
        );
    }
}

#[test]
fn a_violation_is_reported_at_its_waypoint() {
    let mut planner = Case::shipped("flat_walk").planner(1);
    run(&mut planner, u64::MAX);
    let check = |change: &dyn Fn(&mut surefoot_shared_types::message::PlanChunk)| {
        let mut chunks = planner.chunks().to_vec();
        change(&mut chunks[3]);
        self_check(planner.constraints(), &chunks).unwrap_err()
    };
    let fault =
        |waypoint, rejection| SelfCheckError { chunk: 3, waypoint, rejection: Some(rejection) };
    assert_eq!(
        check(&|chunk| chunk.waypoints[2].root_position[1] += 0.5),
        fault(2, Rejection::Balance)
    );
    assert_eq!(
        check(&|chunk| chunk.waypoints[2].root_position[2] -= 0.3),
        fault(2, Rejection::Collision)
    );
    assert_eq!(
        check(&|chunk| chunk.waypoints[2].root_position[2] += 0.004),
        fault(2, Rejection::FootDrift)
    );
    assert_eq!(
        check(&|chunk| chunk.mode = 77),
        SelfCheckError { chunk: 3, waypoint: 0, rejection: None }
    );
}
