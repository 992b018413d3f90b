//! What post-processing makes of a walk is as valid as what was found: the controller's checks
//! hold.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::path::Path;

use preparation::preparation_for;
use surefoot_controller_sim::check_plan;
use surefoot_planner::pipeline::WorkCategory;
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::plan_file::write::plan_from_chunks;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;

/// Swings over obstacles, primitives on a floor, steps on edges, and footholds hardly larger than
/// the soles.
const SCENARIOS: [&str; 6] =
    ["flat_walk", "ibeam_gap", "ibeam_hallway", "stairs", "cinder_blocks", "monkey_bars"];
/// Far more work than by default, so that all motions are gone through.
const SHARE: f64 = 2.0;

#[test]
fn the_controller_accepts_what_was_made_shorter() {
    let folder = tempfile::tempdir().unwrap();
    for name in SCENARIOS {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenarios/{name}.toml"));
        let mut scenario = load_scenario(&path).unwrap();
        scenario.planner.shortcut_work_share = SHARE;
        let (model, world) =
            (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
        let preparation = preparation_for(&model, &scenario.planner);
        let mut planner = Planner::builder(&model, &world, &scenario, preparation).build().unwrap();
        assert_eq!(planner.step(u64::MAX), Status::Done(Outcome::Found), "{name}");
        assert!(
            planner.stats().work_by_category[WorkCategory::Shortcuts as usize] > 100,
            "{name}: nothing was tried"
        );
        let plan = plan_from_chunks(&model, &world, &scenario, planner.chunks(), folder.path());
        let path = folder.path().join("plan.json");
        std::fs::write(&path, serde_json::to_vec(&plan).unwrap()).unwrap();
        let report = check_plan(&load_plan(&path).unwrap(), &path).unwrap();
        assert!(report.is_valid(), "{name}: {:?}", report.violations().next());
    }
}
