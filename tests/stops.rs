//! Walks whose chunks come late: the robot brakes along its path, stands, and goes on; and a robot
//! whose chunks end comes to rest on its path.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;
use std::time::Duration;

use command::{finish, run, surefoot};
use serde_json::Value;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::message::SimulationState;

/// Most polls of an instance, a millisecond apart.
const POLLS_MAX: u32 = 60_000;

/// A smooth walk of two metres on flat ground.
fn short_walk(folder: &Path) -> String {
    let configs = format!("\"{}/configs/", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string("configs/scenarios/flat_walk.toml").unwrap();
    let text = text.replace("\"../", &configs).replace("[9.5, 0.0, 0.0]", "[2.5, 0.0, 0.0]");
    assert!(text.contains("[2.5, 0.0, 0.0]"));
    let file = folder.join("short.toml");
    fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

fn report(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn late_chunks_make_the_robot_brake_and_change_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = short_walk(folder.path());
    let [json, walked] = ["report.json", "walked.json"].map(|name| folder.path().join(name));
    let walk = |options: &[&str]| {
        let common = ["walk", &file, "--motion", "smooth", "--json", json.to_str().unwrap()];
        let output = run(&[&common[..], options].concat());
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        (report(&json), output.out)
    };
    let (in_time, text) = walk(&[]);
    assert_eq!((&in_time["brakes"], &in_time["late_chunks"]), (&0.into(), &0.into()), "{text}");
    assert!(!text.contains("braked"), "{text}");
    let executed = ["--executed", walked.to_str().unwrap()];
    let (late, text) = walk(&[&["--late", "5:0.3"], &executed[..]].concat());
    let brakes = late["brakes"].as_u64().unwrap();
    let stood = late["stood_seconds"].as_f64().unwrap();
    assert!(brakes >= 2 && stood > 0.5, "{text}");
    assert!(text.contains(&format!("braked {brakes} times, stood {stood:.1} s")), "{text}");
    assert_eq!(late["digest"], in_time["digest"]);
    assert_eq!(late["chunks"]["accepted"], in_time["chunks"]["accepted"]);
    // In simulated time, the same chunks come late, and the robot brakes as often.
    let (simulated, _) = walk(&["--late", "5:0.3", "--rate", "0"]);
    assert_eq!((&simulated["brakes"], &simulated["digest"]), (&late["brakes"], &late["digest"]));
    // The motion as walked is a plan that passes every check, and lasts as much longer.
    let checked = run(&["check", walked.to_str().unwrap(), "--scenario", &file]);
    assert_eq!(checked.code, 0, "{}{}", checked.out, checked.err);
    let plan = report(&walked);
    let end = plan["waypoints"].as_array().unwrap().last().unwrap()["t"].as_f64().unwrap();
    let planned = late["walk"]["seconds"].as_f64().unwrap();
    assert!(end > planned + stood && end < planned + stood + 2.0 * brakes as f64, "{end}");
}

#[test]
fn a_robot_whose_planner_is_gone_comes_to_rest_on_its_path() {
    let name = format!("test-stops-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let observer = Observer::open(&instance).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = short_walk(folder.path());
    let smooth = ["--motion", "smooth", "--instance", &name];
    let control = [&["control", &file, "--rate", "2"], &smooth[..]].concat();
    let control = surefoot(&control).spawn().unwrap();
    let plan = [&["plan", &file, "--quiet"], &smooth[..]].concat();
    let mut plan = surefoot(&plan).spawn().unwrap();
    let mut states: Vec<SimulationState> = vec![];
    let receive = |states: &mut Vec<SimulationState>| {
        while let Some(state) = observer.state().unwrap() {
            states.push(state);
        }
    };
    let mut polls = 0;
    let mut poll = |states: &mut Vec<SimulationState>| {
        polls += 1;
        assert!(polls < POLLS_MAX, "{} states", states.len());
        receive(states);
        std::thread::sleep(Duration::from_millis(1));
    };
    let moves = |state: &SimulationState| state.waypoint.root_velocity != [0.0; 6];
    // The planner is killed while the robot walks; the robot stands soon after.
    while states.last().is_none_or(|state| state.waypoint.time < 1.0 || !moves(state)) {
        poll(&mut states);
    }
    plan.kill().unwrap();
    plan.wait().unwrap();
    let mut feedback = observer.feedback().unwrap();
    while feedback.is_none_or(|feedback| feedback.moving == 1 || feedback.brakes == 0) {
        poll(&mut states);
        feedback = observer.feedback().unwrap().or(feedback);
    }
    receive(&mut states);
    let (feedback, last) = (feedback.unwrap(), states.last().unwrap());
    assert!(!moves(last) && feedback.brakes > 0 && feedback.finished == 0, "{last:?}");
    assert!((last.waypoint.time - feedback.rest_state.waypoint.time).abs() < 1e-9);
    let joints = last.waypoint.q.iter().zip(&feedback.rest_state.waypoint.q);
    assert!(joints.into_iter().all(|(a, b)| (a - b).abs() < 1e-9));
    for pair in states.windows(2) {
        let passed = pair[1].waypoint.time - pair[0].waypoint.time;
        assert!((-1e-9..0.01 + 1e-9).contains(&passed), "{passed} at tick {}", pair[1].tick);
    }
    // A new planner goes on from there, and the robot arrives.
    let plan = [&["plan", &file, "--quiet"], &smooth[..]].concat();
    let plan = finish(surefoot(&plan).spawn().unwrap());
    let control = finish(control);
    assert_eq!((plan.code, control.code), (0, 0), "{}{}{}", plan.out, plan.err, control.err);
}

#[test]
fn ramps_keep_the_planners_margin_of_the_zero_moment_point() {
    // Between points of the path the curvature bulges: interpolated between their loads alone, the
    // point is 20 mm off on this walk, and one ramp kept 5.4 mm.
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.json").to_str().unwrap().to_owned();
    let walk = ["plan", "stairs_steep", "--motion", "smooth", "--seed", "21", "--quiet"];
    let planned = run(&[&walk[..], &["--export", &plan]].concat());
    assert_eq!(planned.code, 0, "{}{}", planned.out, planned.err);
    let checked = run(&["check", &plan, "--json"]);
    assert_eq!(checked.code, 0, "{}{}", checked.out, checked.err);
    let checks: Value = serde_json::from_str(&checked.out).unwrap();
    let checks = checks["checks"].as_array().unwrap();
    let zero_moment = checks.iter().find(|check| check["check"] == "zero_moment").unwrap();
    assert!(zero_moment["margin"].as_f64().unwrap() > 6.9e-3, "{zero_moment}");
}
