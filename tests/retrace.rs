//! No plan leads on from where the actual world differs: the robot retraces its steps until one
//! does.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;

use command::{run, scenario};
use serde_json::Value;

/// Walks a scenario in a world that differs from its own by `changes` of its text; answers the
/// report and the text on stderr.
fn walk_in_actual_world(name: &str, seed: u32, changes: &[(&str, &str)]) -> (Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |file: &str| folder.path().join(file).to_str().unwrap().to_owned();
    let mut world = fs::read_to_string(format!("configs/worlds/{name}.toml")).unwrap();
    for (assumed, actual) in changes {
        assert_eq!(world.matches(assumed).count(), 1, "{assumed}");
        world = world.replace(assumed, actual);
    }
    let (ground_truth, json, plan) =
        (path("ground_truth.toml"), path("report.json"), path("plan.json"));
    fs::write(&ground_truth, world).unwrap();
    let output = run(&[
        "walk",
        &scenario(name),
        "--seed",
        &seed.to_string(),
        "--ground-truth",
        &ground_truth,
        "--json",
        &json,
        "--export",
        &plan,
    ]);
    assert_eq!(output.code, 0, "{name}: {}{}", output.out, output.err);
    let check = run(&["check", &plan]);
    assert_eq!(
        check.code, 0,
        "{name}, from where the robot stood at last: {}{}",
        check.out, check.err
    );
    check_torques_go_on(&serde_json::from_slice(&fs::read(plan).unwrap()).unwrap());
    (serde_json::from_slice(&fs::read(json).unwrap()).unwrap(), output.err)
}

/// The largest change of a feed-forward torque at rest from one waypoint to the next, N m.
const REST_TORQUE_STEP_MAX: f64 = 45.0;

/// Every waypoint of a plan states feed-forward torques at rest, and no load moves from one foot to
/// the other between two of them.
fn check_torques_go_on(plan: &Value) {
    let torques = |waypoint: &Value| -> Vec<f64> {
        let of_joints = waypoint["rest_torque"].as_array().unwrap();
        of_joints.iter().map(|torque| torque.as_f64().unwrap()).collect()
    };
    let at: Vec<Vec<f64>> = plan["waypoints"].as_array().unwrap().iter().map(torques).collect();
    assert!(at.iter().all(|torques| torques.iter().any(|torque| *torque != 0.0)));
    for (index, pair) in at.windows(2).enumerate() {
        let steps = pair[0].iter().zip(&pair[1]).map(|(from, to)| (to - from).abs());
        let largest = steps.fold(0.0, f64::max);
        assert!(largest <= REST_TORQUE_STEP_MAX, "{largest} N m after waypoint {index}");
    }
}

#[test]
fn a_lifted_foot_that_collides_returns_to_its_last_stance() {
    let slabs = [
        ("xyz = [0.623845, -0.317517, 0.352143]", "xyz = [0.5996, -0.3357, 0.3434]"),
        ("xyz = [0.697806, 0.055385, 0.540714]", "xyz = [0.7192, 0.0752, 0.5312]"),
        ("xyz = [0.565947, 0.411951, 0.729286]", "xyz = [0.5916, 0.4403, 0.7486]"),
    ];
    let (report, _) = walk_in_actual_world("spiral_steps", 6, &slabs);
    assert!(
        report["replans"].as_u64().unwrap() >= 1 && report["refusal"] == Value::Null,
        "{report}"
    );
}

#[test]
fn the_robot_retraces_further_steps_where_one_is_not_enough() {
    let step = [("xyz = [1.8, 0.0, 0.22]", "xyz = [1.7916, 0.0091, 0.212]")];
    let (report, output) = walk_in_actual_world("stairs", 3, &step);
    assert_eq!(report["outcome"], "accepted");
    assert!(output.contains("no plan found from the rest state"), "{output}");
}

#[test]
fn more_than_eight_differences_are_reported() {
    let bars = [
        "1.72", "1.88", "2.04", "2.2", "2.36", "2.52", "2.68", "2.84", "3.0", "3.16", "3.32",
        "3.48",
    ];
    let changes =
        bars.map(|x| (format!("xyz = [{x}, 0.0, -0.02]"), format!("xyz = [{x}, 0.01, -0.03]")));
    let (report, _) = walk_in_actual_world(
        "monkey_bars",
        1,
        &changes.each_ref().map(|(assumed, actual)| (&assumed[..], &actual[..])),
    );
    assert!(report["outcome"] == "accepted" && report["replans"].as_u64().unwrap() > 8, "{report}");
}
