//! Starts and goals take the height and the tilt of their ground, so that the plan is accepted and
//! reaches its own goal.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[path = "common/own_world.rs"]
mod own_world;

use command::run;
use own_world::write_scenario;
use serde_json::Value;

/// A ramp of 0.3 rad that rises along x.
const WORLD: &str = "mu = 0.6\n[[shapes]]\nname = \"ramp\"\nxyz = [0.0, 0.0, -0.1]\n\
                 rpy = [0.0, -0.3, 0.0]\nbox = { half_extents = [2.0, 1.0, 0.1] }\n";
/// A step up it, with the goal 3 cm below the ramp.
const ENDS: &str = "[start]\nxyz = [0.0, 0.0, 0.00468]\n\
                    [goal]\nxyz = [0.4, 0.0, 0.1]\nposition_tolerance = 0.04\n";

#[test]
fn a_plan_reaches_its_own_goal_on_a_slope() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = write_scenario(folder.path(), WORLD, ENDS);
    let plan = folder.path().join("plan.json").to_str().unwrap().to_owned();
    let output = run(&["plan", &scenario, "--export", &plan]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let exported: Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
    let left = &exported["goal"]["soles"]["left"];
    let slope = 0.3_f64;
    let height = 0.4 * libm::tan(slope) + 0.1 / libm::cos(slope) - 0.1;
    assert!((left["xyz"][2].as_f64().unwrap() - height).abs() < 1e-6, "{left}");
    let pitch = 2.0 * libm::asin(left["quat_xyzw"][1].as_f64().unwrap());
    assert!((pitch + slope).abs() < 1e-6, "{left}");
    for arguments in [&["check", &plan][..], &["check", &plan, "--scenario", &scenario]] {
        let output = run(arguments);
        assert_eq!(output.code, 0, "{arguments:?}: {}{}", output.out, output.err);
    }
}

/// A bare floor.
const FLOOR: &str = "mu = 0.6\n[[shapes]]\nname = \"floor\"\nxyz = [0.0, 0.0, -0.1]\n\
                 box = { half_extents = [2.0, 1.0, 0.1] }\n";

#[test]
fn a_start_beside_the_height_of_its_ground_is_set_down() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.json").to_str().unwrap().to_owned();
    for height in ["0.0007", "-0.0007"] {
        let ends =
            format!("[start]\nxyz = [0.0, 0.0, {height}]\n[goal]\nxyz = [0.2, 0.0, {height}]\n");
        let scenario = write_scenario(folder.path(), FLOOR, &ends);
        let output = run(&["plan", &scenario, "--export", &plan]);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        let output = run(&["check", &plan, "--scenario", &scenario]);
        assert_eq!(output.code, 0, "{height}: {}{}", output.out, output.err);
    }
}
