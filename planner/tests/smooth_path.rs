//! The smooth path of a plan, from its points alone: continuous with two derivatives, soles in
//! place, balanced, and the swing foot above the ground.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, preparation_for, run};
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::mode::Mode;
use surefoot_planner::plan::self_check::mode_of_contacts;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::timing::path_point::{PathPoint, PathSpan};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::base::spatial::{rotation_distance, scaled_axis_from_rotation};
use surefoot_shared_types::config::planner::FOOT_DRIFT_MAX;

/// Largest distance of a stance sole from its foothold, m and rad.
const SOLE_ERROR_MAX: f64 = 1e-6;

/// Largest deviation (m and rad) of a point from the one before, continued by both derivatives.
const JUMP_MAX: f64 = 1e-2;

fn smooth_planner(name: &str) -> Planner {
    let mut planner = Case::smooth(name).planner(1);
    assert_eq!(run(&mut planner, 20_000), Outcome::Found, "{name}");
    planner
}

fn configuration_of(point: &PathPoint) -> Configuration {
    Configuration { world_from_root: point.world_from_root, q: point.q }
}

/// The differences of root and joints from one point to another, as derivatives are ordered.
fn difference(from: &PathPoint, to: &PathPoint) -> Vec<f64> {
    let shift = to.world_from_root.translation - from.world_from_root.translation;
    let turn = scaled_axis_from_rotation(
        to.world_from_root.rotation * from.world_from_root.rotation.conjugate(),
    );
    let joints = to.q.iter().zip(&from.q).map(|(to, from)| to - from);
    shift.to_array().into_iter().chain(turn.to_array()).chain(joints).collect()
}

/// The largest deviation of each point from the one before, continued by its derivatives.
fn largest_jump(points: &[PathPoint]) -> f64 {
    let jump = |pair: &[PathPoint]| {
        let [from, to] = pair else { return 0.0 };
        let step = to.parameter - from.parameter;
        let moved = difference(from, to);
        let expected = |index: usize| {
            let mean = 0.5 * (from.first[index] + to.first[index]);
            mean * step - (to.second[index] - from.second[index]) * step * step / 12.0
        };
        moved
            .iter()
            .enumerate()
            .map(|(index, moved)| (moved - expected(index)).abs())
            .fold(0.0, f64::max)
    };
    points.windows(2).map(jump).fold(0.0, f64::max)
}

fn check_span(
    constraints: &Constraints,
    points: &[PathPoint],
    mode: &Mode,
    sole_error_max: f64,
    name: &str,
) {
    let mut state = KinematicState::default();
    let margin = constraints.com_margin(mode);
    for point in points {
        state.update(&constraints.robot, &configuration_of(point));
        let inside = mode.region.margin(state.com.truncate());
        // A plan may begin nearer to the border of its support polygon.
        assert!(inside >= margin - 1e-9 || point.parameter == 0.0, "{name}: {inside} < {margin}");
        for limb in (0..2).filter(|limb| mode.is_stance(*limb)) {
            let sole = state.world_from_sole(&constraints.robot, limb);
            let placed = &mode.world_from_soles[limb];
            let error = sole.translation.distance(placed.translation);
            assert!(error < sole_error_max, "{name}: sole {limb} is {error} m away");
            assert!(
                rotation_distance(sole.rotation, placed.rotation) < 2.0 * sole_error_max,
                "{name}"
            );
        }
    }
}

/// Checks a plan's path. Returns its number of rests and of phases with the searched motion.
fn check_path(name: &str) -> [u64; 2] {
    let planner = smooth_planner(name);
    let (points, spans) = planner.smooth_path().unwrap();
    let mut next = 0;
    for (index, span) in spans.iter().enumerate() {
        let PathSpan { first, last, starts_at_rest, support, contacts, .. } = span;
        assert_eq!(*first, if index > 0 && !starts_at_rest { next - 1 } else { next });
        assert!(last > first && contacts.is_sorted_by_key(|contact| contact.limb));
        let span_points = &points[*first..=*last];
        if index > 0 {
            let gap = difference(&points[first - 1], &points[*first]);
            assert!(!starts_at_rest || gap.iter().all(|gap| gap.abs() < 1e-12), "{name}: {index}");
        }
        let jump = largest_jump(span_points);
        assert!(jump < JUMP_MAX, "{name}: jump of {jump} in span {index}");
        let mode = mode_of_contacts(*support, contacts).unwrap();
        // Between two waypoints of a searched motion the soles drift.
        let is_searched = span_points.iter().all(|point| point.second.iter().all(|x| *x == 0.0));
        let sole_error_max = if is_searched { FOOT_DRIFT_MAX } else { SOLE_ERROR_MAX };
        check_span(planner.constraints(), span_points, &mode, sole_error_max, name);
        next = last + 1;
    }
    assert_eq!(next, points.len());
    let stats = planner.stats();
    assert_eq!([stats.beyond_limits, stats.without_stop], [0; 2], "{name}");
    [stats.rests, stats.searched_phases]
}

#[test]
fn a_plan_made_in_parts_is_the_same() {
    for name in ["ibeam_hallway", "beam_narrow"] {
        let case = Case::smooth(name);
        let preparation = preparation_for(&case.model, &case.scenario.planner);
        let builder = Planner::builder(&case.model, &case.world, &case.scenario, preparation);
        let mut parts = builder.in_parts().build().unwrap();
        assert_eq!(parts.step_to_first_chunk(u64::MAX, &|| true), Status::Working, "{name}");
        let first = parts.final_chunks().len();
        assert!(first > 0, "{name}");
        assert_eq!(run(&mut parts, u64::MAX), Outcome::Found, "{name}");
        let whole = smooth_planner(name);
        assert!(first < whole.chunks().len(), "{name}");
        assert_eq!(parts.digest(), whole.digest(), "{name}");
    }
}

#[test]
fn flat_ground_needs_no_rest() {
    assert_eq!(check_path("flat_walk"), [0, 0]);
}

#[test]
fn arms_that_stand_at_their_limits_need_no_rest() {
    let mut case = Case::smooth("flat_walk");
    let elbow = case.model.joints.iter().position(|joint| joint.name == "left_elbow").unwrap();
    case.model.joints[elbow].upper = case.model.standing_q[elbow];
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, 20_000), Outcome::Found);
    assert_eq!([planner.stats().rests, planner.stats().searched_phases], [0, 0]);
}

#[test]
fn stairs_need_no_rest() {
    assert_eq!(check_path("stairs_bauzil"), [0, 0]);
}

#[test]
fn a_hallway_with_a_beam_keeps_few_searched_motions() {
    let [_, searched] = check_path("ibeam_hallway");
    assert!(searched <= 4, "{searched} searched phases");
}

#[test]
fn stepping_stones_need_no_rest() {
    assert_eq!(check_path("stepping_stones"), [0, 0]);
}
