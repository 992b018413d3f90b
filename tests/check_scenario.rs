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

/// A part of a plan, from a waypoint within one phase to one within another one.
fn cut(plan: &mut Value, [first, last]: [usize; 2], [from, to]: [usize; 2]) {
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let mut phases: Vec<Value> = plan["phases"].as_array().unwrap()[first..=last].to_vec();
    for phase in &mut phases {
        let [begin, end] = ["first", "last"].map(|name| number(&phase[name]).clamp(from, to));
        (phase["first"], phase["last"]) = ((begin - from).into(), (end - from).into());
    }
    plan["phases"] = phases.into();
    plan["waypoints"] = plan["waypoints"].as_array().unwrap()[from..=to].to_vec().into();
}

#[test]
fn a_plan_that_begins_or_ends_on_one_foot_is_no_answer() {
    let singles = |plan: &Value| -> Vec<(usize, usize, usize)> {
        let phases = plan["phases"].as_array().unwrap().iter().enumerate();
        let single = phases.filter(|(_, phase)| phase["mode"] != "double");
        let number = |value: &Value| value.as_u64().unwrap() as usize;
        single.map(|(at, phase)| (at, number(&phase["first"]), number(&phase["last"]))).collect()
    };
    let (_one, ends) = planned(|plan| {
        let &(phase, _, last) = singles(plan).last().unwrap();
        cut(plan, [0, phase], [0, last - 2]);
    });
    let (_other, begins) = planned(|plan| {
        let (phase, first, _) = singles(plan)[0];
        let last = plan["phases"].as_array().unwrap().len() - 1;
        let end = plan["waypoints"].as_array().unwrap().len() - 1;
        cut(plan, [phase, last], [first + 2, end]);
    });
    for (plan, text) in [(ends, "the plan ends on one foot"), (begins, "the plan begins on one")] {
        let output = run(&["check", &plan, "--scenario", &scenario("stairs_bauzil")]);
        assert_eq!(output.code, 4, "{}{}", output.out, output.err);
        assert!(output.out.contains(text), "{}", output.out);
    }
}

/// The robot of a plan stands still for so many seconds, with a phase for each of them.
fn stand(plan: &mut Value, seconds: usize) {
    let (waypoint, phase) = (plan["waypoints"][0].clone(), plan["phases"][0].clone());
    let (mut waypoints, mut phases) = (vec![waypoint.clone(); seconds + 1], vec![phase; seconds]);
    waypoints.iter_mut().enumerate().for_each(|(at, waypoint)| waypoint["t"] = at.into());
    for (at, phase) in phases.iter_mut().enumerate() {
        (phase["first"], phase["last"]) = (at.into(), (at + 1).into());
    }
    (plan["waypoints"], plan["phases"]) = (waypoints.into(), phases.into());
    plan["goal"] = plan["start"].clone();
}

#[test]
fn a_kept_foot_is_compared_with_where_it_was_set_down() {
    let creeping = |step: f64| {
        planned(|plan| {
            stand(plan, 3);
            for (at, phase) in plan["phases"].as_array_mut().unwrap().iter_mut().enumerate() {
                for contact in phase["contacts"].as_array_mut().unwrap() {
                    let x = &mut contact["sole_pose"]["xyz"][0];
                    *x = (x.as_f64().unwrap() + step * at as f64).into();
                }
            }
        })
    };
    for (step, code) in [(0.4e-6, 0), (0.7e-6, 4)] {
        let (_folder, plan) = creeping(step);
        let output = run(&["check", &plan]);
        assert_eq!(output.code, code, "{}{}", output.out, output.err);
        assert_eq!(output.out.contains("from where it stood before"), code == 4, "{}", output.out);
    }
}

#[test]
fn links_that_are_clear_where_a_plan_begins_are_not_excused_by_the_standing_posture() {
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/robots/hubo");
    let file = std::fs::read_to_string(format!("{robots}/robot.toml")).unwrap();
    let file = file.replace("\"hubo.urdf\"", &format!("\"{robots}/hubo.urdf\""));
    let into_torso = |standing: &str| {
        let (folder, plan) = planned(|plan| {
            stand(plan, 20);
            let names = plan["joint_names"].as_array().unwrap();
            let joint = names.iter().position(|name| name == "left_shoulder_roll").unwrap();
            for (at, waypoint) in plan["waypoints"].as_array_mut().unwrap().iter_mut().enumerate() {
                let begin = waypoint["q"][joint].as_f64().unwrap();
                waypoint["q"][joint] = (begin + (-0.3 - begin) * at as f64 / 20.0).into();
            }
            plan["robot"]["robot_file"] = "sunk.toml".into();
        });
        let changed = file.replace("left_shoulder_roll = 0.15", standing);
        assert!(changed.contains(standing));
        std::fs::write(folder.path().join("sunk.toml"), changed).unwrap();
        run(&["check", &plan])
    };
    for standing in ["left_shoulder_roll = 0.15", "left_shoulder_roll = -0.3"] {
        let output = into_torso(standing);
        assert!(output.out.contains("allowed overlaps: those of"), "{}{}", output.out, output.err);
        assert!(output.out.contains("torso overlaps left_"), "{}", output.out);
    }
}
