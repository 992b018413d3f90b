//! Goals near the start on a bare floor: turns on the spot, steps sideways and backward, and
//! everything between are found directly.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::f64::consts::{PI, TAU};

use common::{Case, run};
use glam::DVec3;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::{Outcome, Planner};

/// Work that a goal within 1.5 m may take.
const WORK_MAX: u64 = 30_000;

/// The shipped robot at the origin of a bare floor, with a goal in its own frame and tight
/// tolerances.
fn goal([dx, dy]: [f64; 2], yaw: f64, stance_width: f64) -> Case {
    let mut case = Case::shipped("flat_walk");
    case.world.shapes.clear();
    let scenario = &mut case.scenario;
    (scenario.start.position, scenario.start.yaw) = (DVec3::ZERO, 0.0);
    (scenario.goal.position, scenario.goal.yaw) = (DVec3::new(dx, dy, 0.0), yaw);
    (scenario.start.stance_width, scenario.goal.stance_width) = (stance_width, stance_width);
    (scenario.goal_tolerance.position, scenario.goal_tolerance.yaw) = (0.01, 0.01);
    case.with_box([0.0, 0.0, -0.25], [5.0, 5.0, 0.25])
        .configured(|planner| planner.work_max = WORK_MAX)
}

/// The planner after its search, which found a plan.
fn found(case: &Case, what: &str) -> Planner {
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "{what}");
    planner
}

#[test]
fn turns_on_the_spot_take_few_steps() {
    for (yaw, steps_max) in [(0.2, 2), (-0.4, 2), (0.65, 4), (-1.0, 4), (2.0, 8), (3.1, 10)] {
        let planner = found(&goal([0.0, 0.0], yaw, 0.2), &format!("turn of {yaw} rad"));
        assert!(planner.steps() <= steps_max, "turn of {yaw} rad: {} steps", planner.steps());
    }
}

#[test]
fn steps_sideways_and_backward_are_direct() {
    let goals = [([0.0, 0.15], 2), ([0.0, -0.3], 4), ([-0.3, 0.0], 2), ([-0.9, 0.0], 4)];
    for (offset, steps_max) in goals.into_iter().chain([([1.2, 0.0], 5)]) {
        let planner = found(&goal(offset, 0.0, 0.2), &format!("{offset:?}"));
        assert!(planner.steps() <= steps_max, "{offset:?}: {} steps", planner.steps());
        assert_eq!(planner.stats().routes, 0, "{offset:?}: stage P was asked for a route");
    }
}

#[test]
fn goals_within_the_tolerances_are_walked_to() {
    let goals = [([0.05, 0.0], 0.0), ([0.0, 0.08], 0.0), ([-0.1, 0.0], 0.0), ([0.0, 0.0], 0.3)];
    for (offset, yaw) in goals {
        let mut case = goal(offset, yaw, 0.2);
        let tolerance = &mut case.scenario.goal_tolerance;
        (tolerance.position, tolerance.yaw) = (0.1, 0.35);
        let steps = found(&case, &format!("{offset:?}, {yaw} rad")).steps();
        assert!((1..=2).contains(&steps), "{offset:?}, {yaw} rad: {steps} steps");
    }
    assert_eq!(found(&goal([0.004, 0.0], 0.009, 0.2), "at the goal").steps(), 0);
}

#[test]
fn random_goals_are_found_from_narrow_and_wide_stances() {
    for index in 0..16 {
        let mut random = Random::new(7, Stream::Preparation, index, 0);
        let radius = 1.5 * libm::sqrt(random.uniform(0.0, 1.0));
        let (sin, cos) = libm::sincos(random.uniform(0.0, TAU));
        let yaw = random.uniform(-PI, PI);
        let width = [0.2, 0.32][index as usize % 2];
        let offset = [radius * cos, radius * sin];
        let planner = found(&goal(offset, yaw, width), &format!("{offset:?}, {yaw}, {width}"));
        assert!(planner.steps() <= 14, "{offset:?}, {yaw}, {width}: {} steps", planner.steps());
    }
}

#[test]
fn an_obstacle_on_the_straight_way_leaves_the_goal_to_stage_p() {
    let case = goal([1.4, 0.0], 0.0, 0.2)
        .with_box([0.7, 0.0, 0.5], [0.05, 0.6, 0.5])
        .configured(|planner| planner.work_max = 400_000);
    let planner = found(&case, "around a wall");
    assert!(planner.stats().routes > 0, "the wall stands in the way");
}

#[test]
fn a_pit_on_the_straight_way_leaves_the_goal_to_stage_p() {
    // Direct steps find no ground in the pit before any path of theirs is tried.
    let mut case = goal([1.4, 0.0], 0.0, 0.2);
    case.world.shapes.clear();
    let case = case
        .with_box([-1.0, 0.0, -0.25], [1.2, 2.0, 0.25])
        .with_box([2.4, 0.0, -0.25], [1.2, 2.0, 0.25])
        .with_box([0.7, 1.2, -0.25], [0.6, 0.4, 0.25])
        .configured(|planner| planner.work_max = 200_000);
    for seed in 1..=3 {
        let planner = found(&case.clone().with_seed(seed), "around a pit");
        assert!(planner.stats().routes > 0, "the pit lies in the way");
    }
}

#[test]
fn a_kerb_is_climbed_directly() {
    let mut case = goal([1.0, 0.0], 0.0, 0.2).with_box([1.0, 0.0, 0.05], [0.5, 1.0, 0.05]);
    case.scenario.goal.position.z = 0.1;
    found(&case, "onto a kerb");
}

#[test]
fn a_sole_at_the_goal_is_no_farther_aside_than_its_tolerance() {
    // At the left sole's place at the goal a small block is under less of the sole than it needs; a
    // centimetre or two aside more of it is.
    let case = |tolerance: f64| {
        let mut case = goal([0.3, 0.0], 0.0, 0.2);
        case.world.shapes.clear();
        case.scenario.goal_tolerance.position = tolerance;
        case.with_box([0.0, 0.0, -0.25], [0.15, 0.5, 0.25])
            .with_box([0.3, -0.1, -0.25], [0.15, 0.08, 0.25])
            .with_box([0.32, 0.155, -0.25], [0.06, 0.045, 0.25])
    };
    let planner = found(&case(0.05), "a little aside");
    let last = planner.chunks().last().unwrap();
    let left = last.contacts().iter().find(|contact| contact.limb == 0).unwrap();
    assert!(left.position[1] > 0.105, "{:?}", left.position);
    let outcome = run(&mut case(5e-3).planner(1), u64::MAX);
    assert!(matches!(outcome, Outcome::GoalInvalid(_)), "{outcome:?}");
}
