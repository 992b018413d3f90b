//! The independent judge's example plans, where they exist: the good ones pass, the bad ones fail
//! for the right reason. A clone has none, so `SUREFOOT_REQUIRE_ALL` does not ask for them.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a panic fails the test; skipped tests are printed"
)]

use std::path::Path;

use surefoot_controller_sim::{PlanReport, check_plan};
use surefoot_shared_types::message::Check;
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::plan_format::blocks::PlanFile;

/// Beside the repository.
const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/judge/examples");

fn check_example(name: &str) -> Option<PlanReport> {
    check_changed(name, |_| ())
}

fn check_changed(name: &str, change: impl FnOnce(&mut PlanFile)) -> Option<PlanReport> {
    let path = Path::new(EXAMPLES).join(name);
    if !path.exists() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    let mut plan = load_plan(&path).unwrap();
    change(&mut plan);
    let report = check_plan(&plan, &path).unwrap();
    for line in &report.checks {
        let violation = line
            .violation
            .as_ref()
            .map(|found| format!("phase {}: {}", found.phase, found.violation));
        println!(
            "{name}: {} {:?} {}",
            line.check.name(),
            line.worst,
            violation.unwrap_or_default()
        );
    }
    Some(report)
}

fn assert_valid(name: &str) {
    if let Some(report) = check_example(name) {
        assert!(report.is_valid(), "{report:#?}");
    }
}

fn assert_violates(name: &str, check: Check) {
    if let Some(report) = check_example(name) {
        assert!(report.violations().any(|found| found.violation.check == check), "{report:#?}");
    }
}

#[test]
fn a_walk_of_talos_is_valid() {
    assert_valid("talos_flat.json");
}

/// The example's speed jumps by more than the contacts can hold within 0.2 s.
#[test]
fn a_walk_of_g1_over_terrain_is_valid_at_half_its_speed_and_only_too_fast_at_its_own() {
    let slower = |plan: &mut PlanFile| plan.waypoints.iter_mut().for_each(|at| at.t *= 2.0);
    if let Some(report) = check_changed("g1_terrain.json", slower) {
        assert!(report.is_valid(), "{report:#?}");
    }
    if let Some(report) = check_example("g1_terrain.json") {
        let mut violated = report.violations().map(|found| found.violation.check);
        assert!(violated.all(|check| check == Check::ZeroMoment), "{report:#?}");
    }
}

#[test]
fn a_sliding_foot_is_found() {
    assert_violates("g1_bad_foot_slide5mm.json", Check::Contact);
}

#[test]
fn a_ridge_under_the_swing_foot_is_found() {
    assert_violates("g1_bad_ridge_under_swing.json", Check::Collision);
}

#[test]
fn a_centre_of_mass_outside_the_support_is_found() {
    assert_violates("talos_bad_com_outside.json", Check::Balance);
}
