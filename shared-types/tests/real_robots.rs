//! Robots of other projects load unchanged. Their files lie beside the repository. Without them the
//! tests pass, also with `SUREFOOT_REQUIRE_ALL`: a clone does not have them.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, not input handling"
)]

use std::path::Path;

use surefoot_shared_types::plan_format::blocks::RobotBlock;
use surefoot_shared_types::robot::load::robot_from_block;
use surefoot_shared_types::robot::model::RobotModel;

fn load(name: &str) -> Option<RobotModel> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/robots").join(name);
    let path = folder.join("robot.json");
    if !path.is_file() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    let block: RobotBlock = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    Some(robot_from_block(&block, &folder, &path).unwrap())
}

#[test]
fn talos_of_primitives_loads() {
    let Some(robot) = load("talos_prim") else { return };
    assert_eq!(robot.joints.len(), 30);
    assert!((robot.mass() - 90.0).abs() < 5.0, "{}", robot.mass());
    assert_eq!(robot.chain(robot.feet[0].link).len(), 6);
}

#[test]
fn talos_of_meshes_loads() {
    let Some(robot) = load("talos") else { return };
    assert_eq!(robot.joints.len(), 30);
}

#[test]
fn g1_loads() {
    let Some(robot) = load("g1") else { return };
    assert_eq!(robot.joints.len(), 29);
}

#[test]
fn h1_2_loads() {
    let Some(robot) = load("h1_2") else { return };
    assert_eq!(robot.joints.len(), 27);
}
