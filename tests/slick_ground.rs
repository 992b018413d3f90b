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

/// A floor with a coefficient of friction of 0.002, a tenth of that of wet ice.
const WORLD: &str = "mu = 0.002\n[[shapes]]\nname = \"floor\"\nxyz = [0.0, 0.0, -0.1]\n\
                 box = { half_extents = [2.0, 1.0, 0.1] }\n";
/// A step of 15 cm.
const ENDS: &str = "[start]\nxyz = [0.0, 0.0, 0.0]\n\
                    [goal]\nxyz = [0.15, 0.0, 0.0]\n";

#[test]
fn a_plan_on_slick_ground_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = write_scenario(folder.path(), WORLD, ENDS);
    let plan = folder.path().join("plan.json").to_str().unwrap().to_owned();
    for motion in ["smooth", "quasi_static"] {
        let output = run(&["plan", &scenario, "--motion", motion, "--export", &plan]);
        assert_eq!(output.code, 0, "{motion}: {}{}", output.out, output.err);
        let output = run(&["check", &plan, "--scenario", &scenario]);
        assert_eq!(output.code, 0, "{motion}: {}{}", output.out, output.err);
    }
}
