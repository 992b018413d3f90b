//! On slick ground the robot walks as slowly as friction demands, by both kinds of motion, and the
//! controller accepts the plan.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[path = "common/own_world.rs"]
mod own_world;

use command::run;
use own_world::write_scenario;

/// A floor with this coefficient of friction.
fn floor(friction: f64) -> String {
    format!(
        "mu = {friction}\n[[shapes]]\nname = \"floor\"\nxyz = [0.0, 0.0, -0.1]\n\
         box = {{ half_extents = [2.0, 2.0, 0.1] }}\n"
    )
}

/// A walk straight ahead, m, in this direction, rad.
fn ahead(distance: f64, yaw: f64) -> String {
    let (sin, cos) = libm::sincos(yaw);
    let (x, y) = (distance * cos, distance * sin);
    format!(
        "[start]\nxyz = [0.0, 0.0, 0.0]\nyaw = {yaw}\n\
         [goal]\nxyz = [{x}, {y}, 0.0]\nyaw = {yaw}\n"
    )
}

/// Plans the walk with a kind of motion, and has it checked.
fn assert_accepted(motion: &str, friction: f64, ends: &str) {
    let folder = tempfile::tempdir().unwrap();
    let scenario = write_scenario(folder.path(), &floor(friction), ends);
    let plan = folder.path().join("plan.json").to_str().unwrap().to_owned();
    let output = run(&["plan", &scenario, "--motion", motion, "--export", &plan]);
    assert_eq!(output.code, 0, "{motion}: {}{}", output.out, output.err);
    let output = run(&["check", &plan, "--scenario", &scenario]);
    assert_eq!(output.code, 0, "{motion} {friction}: {}{}", output.out, output.err);
}

#[test]
fn a_plan_on_slick_ground_is_accepted() {
    // A tenth of the friction of wet ice.
    for motion in ["smooth", "quasi_static"] {
        assert_accepted(motion, 0.002, &ahead(0.15, 0.0));
    }
}

#[test]
fn friction_holds_in_every_direction() {
    // The controller's pyramids have eight sides at fixed directions of the world.
    for yaw in [0.38, 0.58] {
        assert_accepted("smooth", 0.05, &ahead(1.2, yaw));
    }
}
