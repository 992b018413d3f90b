//! `surefoot check --scenario`: a plan is an answer to the scenario's problem, by its limits.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[path = "common/own_world.rs"]
mod own_world;

use command::{run, scenario};
use own_world::write_scenario;
use serde_json::Value;

/// The plan of a short scenario, changed, in a folder that lives as long as the test.
fn planned(change: impl Fn(&mut Value)) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json").to_str().unwrap().to_owned();
    let name = scenario("stairs_bauzil");
    let arguments = ["plan", &name, "--motion", "quasi_static", "--export", &path];
    assert_eq!(run(&arguments).code, 0);
    let mut plan: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    change(&mut plan);
    std::fs::write(&path, plan.to_string()).unwrap();
    (folder, path)
}

#[test]
fn a_plan_is_an_answer_to_its_own_scenario_only() {
    let (_folder, plan) = planned(|_| ());
    let own = run(&["check", &plan, "--scenario", &scenario("stairs_bauzil")]);
    assert_eq!(own.code, 0, "{}{}", own.out, own.err);
    assert!(own.out.contains("limits: those of"), "{}", own.out);
    let other = run(&["check", &plan, "--scenario", &scenario("flat_walk")]);
    assert_eq!(other.code, 4, "{}{}", other.out, other.err);
}

#[test]
fn a_plan_may_tighten_limits_and_never_loosen_them() {
    let limit = |plan: &mut Value, value: f64| {
        let names: Vec<Value> = plan["joint_names"].as_array().unwrap().clone();
        let limits =
            names.into_iter().map(|name| (name.as_str().unwrap().to_owned(), value.into()));
        plan["robot"]["acceleration_limits"] = Value::Object(limits.collect());
    };
    let (_folder, tight) = planned(|plan| limit(plan, 1.0));
    let (_other, loose) = planned(|plan| {
        limit(plan, 1e6);
        for waypoint in plan["waypoints"].as_array_mut().unwrap() {
            waypoint["t"] = (0.14 * waypoint["t"].as_f64().unwrap()).into();
        }
    });
    for plan in [&tight, &loose] {
        for arguments in
            [&["check", plan][..], &["check", plan, "--scenario", &scenario("stairs_bauzil")]]
        {
            let output = run(arguments);
            assert_eq!(output.code, 4, "{arguments:?}: {}{}", output.out, output.err);
            assert!(output.out.contains("has to accelerate"), "{}", output.out);
        }
    }
    let output = run(&["check", &loose]);
    assert!(output.out.contains("may tighten the default"), "{}", output.out);
}

#[test]
fn place_and_heading_of_a_goal_have_a_tolerance_each() {
    let floor = "mu = 0.6\n[[shapes]]\nname = \"floor\"\nxyz = [0.0, 0.0, -0.1]\n\
                 box = { half_extents = [1.0, 1.0, 0.1] }\n";
    let ends = "[start]\nxyz = [0.0, 0.0, 0.0]\n[goal]\nxyz = [0.0, 0.0, 0.0]\n";
    let folders = [0, 1, 2].map(|_| tempfile::tempdir().unwrap());
    let scenario = write_scenario(folders[0].path(), floor, &format!("{ends}yaw = 0.3\n"));
    let plan = folders[0].path().join("plan.json").to_str().unwrap().to_owned();
    let output = run(&["plan", &scenario, "--export", &plan]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    // Turned by 0.3 rad from another goal: however far its soles may be from their places, they may
    // not be turned farther.
    for (folder, turn_max, code) in [(&folders[1], 0.31, 0), (&folders[2], 0.29, 4)] {
        let ends = format!("{ends}position_tolerance = 1.0\nyaw_tolerance = {turn_max}\n");
        let other = write_scenario(folder.path(), floor, &ends);
        let output = run(&["check", &plan, "--scenario", &other]);
        assert_eq!(output.code, code, "{}{}", output.out, output.err);
        assert_eq!(output.out.contains("turned from its pose by 0.3"), code == 4, "{}", output.out);
    }
}

#[test]
fn how_the_robot_stands_is_read_in_its_robot_file() {
    let (_folder, plan) = planned(|_| ());
    let output = run(&["check", &plan]).out;
    assert!(output.contains("standing posture and allowed overlaps: those of /"), "{output}");
    let (_other, plan) = planned(|plan| plan["robot"]["robot_file"] = "gone.toml".into());
    let output = run(&["check", &plan]).out;
    assert!(output.contains("gone.toml, which the plan names, is not there"), "{output}");
}

#[test]
fn links_without_a_shape_and_pairs_that_may_overlap_are_named() {
    let (_folder, plan) = planned(|_| ());
    let output = run(&["check", &plan]).out;
    for text in ["link left_hip_roll_link (1.60 kg)", "may overlap: left_thigh and left_shin"] {
        assert!(output.contains(text), "{text}: {output}");
    }
}

#[test]
fn the_scenario_says_how_the_robot_stands_whatever_file_the_plan_names() {
    let (folder, plan) = planned(|plan| plan["robot"]["robot_file"] = "broken.toml".into());
    std::fs::write(folder.path().join("broken.toml"), "no robot file").unwrap();
    let alone = run(&["check", &plan]);
    assert!(alone.code == 2 && alone.err.contains("broken.toml:1"), "{}", alone.err);
    let output = run(&["check", &plan, "--scenario", &scenario("stairs_bauzil")]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
}

#[test]
fn a_plan_that_left_its_robot_behind_says_so() {
    let (folder, plan) = planned(|_| ());
    let moved = folder.path().join("a/b/c/plan.json");
    std::fs::create_dir_all(moved.parent().unwrap()).unwrap();
    std::fs::rename(&plan, &moved).unwrap();
    for command in ["check", "explain"] {
        let output = run(&[command, moved.to_str().unwrap()]);
        assert_eq!(output.code, 2, "{}", output.out);
        assert!(
            output.err.contains("a/b/c/plan.json: robot.urdf: there is no file"),
            "{}",
            output.err
        );
    }
}
