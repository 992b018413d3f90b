//! Exported walks stand in physics: they are replayed in MuJoCo by `tools/replay_mujoco.py`.
//! Skipped without the Python packages, or failed if `SUREFOOT_REQUIRE_ALL` is set.
//! `SUREFOOT_PYTHON` names another interpreter.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped, and what it measured")]
#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use command::{run, scenario};
use serde_json::Value;

/// The interpreter, if it has what the tool needs.
fn python() -> Option<String> {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports = ["-c", "import mujoco, numpy"];
    let found = Command::new(&python).args(imports).stderr(Stdio::null()).status();
    if found.is_ok_and(|status| status.success()) {
        return Some(python);
    }
    absent::skip(&format!("{python} lacks mujoco or numpy; pip install mujoco numpy"));
    None
}

/// Replays a plan; the exit code and the line that the tool prints.
fn replay(python: &str, plan: &Path, options: &[&str]) -> (i32, String) {
    let tool = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/replay_mujoco.py");
    let output = Command::new(python).arg("-B").arg(tool).arg(plan).args(options).output().unwrap();
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
    print!("{text}");
    (output.status.code().unwrap(), text)
}

/// The number in a line after one text and before another.
fn number(line: &str, before: &str, after: &str) -> f64 {
    let rest = line.split_once(before).unwrap_or_else(|| panic!("{line}")).1;
    rest.split_once(after).unwrap().0.trim().parse().unwrap()
}

fn assert_stands((code, line): (i32, String)) {
    assert_eq!(code, 0, "{line}");
    assert!(number(&line, "root error", "mm at most") <= 50.0, "{line}");
    assert!(number(&line, "landings, at most", "mm off") <= 5.0, "{line}");
}

/// Times of all waypoints times a factor, with the motion's derivatives to match.
fn retime(plan: &mut Value, factor: f64) {
    for waypoint in plan["waypoints"].as_array_mut().unwrap() {
        let scaled = |value: &Value, by: f64| Value::from(value.as_f64().unwrap() * by);
        waypoint["t"] = scaled(&waypoint["t"], factor);
        for (name, by) in [("velocity", 1.0 / factor), ("acceleration", factor.powi(-2))] {
            for number in waypoint[name].as_array_mut().unwrap() {
                *number = scaled(number, by);
            }
        }
    }
}

#[test]
fn walks_stand_at_their_own_times_and_fall_at_twice_the_speed() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.json");
    let path = plan.to_str().unwrap();
    for name in ["stairs_bauzil", "stepping_stones"] {
        let file = scenario(name);
        let planned = run(&["plan", &file, "--motion", "smooth", "--quiet", "--export", path]);
        assert_eq!(planned.code, 0, "{}{}", planned.out, planned.err);
        assert_stands(replay(&python, &plan, &[]));
    }
    let mut hasty: Value = serde_json::from_slice(&fs::read(&plan).unwrap()).unwrap();
    retime(&mut hasty, 0.5);
    fs::write(&plan, hasty.to_string()).unwrap();
    let (code, line) = replay(&python, &plan, &[]);
    assert!(code == 1 && line.contains("FALLS"), "{line}");
    fs::write(&plan, "{}").unwrap();
    let (code, line) = replay(&python, &plan, &[]);
    assert!(code == 2 && line.contains("cannot be replayed"), "{line}");
}

#[test]
fn a_walk_with_stops_stands_with_other_masses_friction_and_delays() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let walked = folder.path().join("walked.json");
    let file = scenario("stairs_bauzil");
    let late = ["--motion", "smooth", "--quiet", "--late", "3", "--executed"];
    let output = run(&[&["walk", &file], &late[..], &[walked.to_str().unwrap()]].concat());
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    assert!(output.out.contains("braked"), "{}", output.out);
    assert_stands(replay(&python, &walked, &[]));
    assert_stands(replay(&python, &walked, &["--disturb", "1"]));
}

/// A binary STL file of boxes between two corners, m.
fn stl(boxes: &[[[f32; 3]; 2]]) -> Vec<u8> {
    let faces =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [1, 5, 7, 3], [0, 2, 6, 4]];
    let mut bytes = vec![0; 80];
    bytes.extend((12 * boxes.len() as u32).to_le_bytes());
    for corners in boxes {
        for [a, b, c, d] in faces {
            for triangle in [[a, b, c], [a, c, d]] {
                bytes.extend([0; 12]);
                for corner in triangle {
                    let place = [2, 1, 0].map(|bit| corners[corner >> bit & 1][2 - bit]);
                    place.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
                }
                bytes.extend([0; 2]);
            }
        }
    }
    bytes
}

#[test]
fn a_walk_over_a_threshold_of_a_binary_stl_file_stands() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let floor = [[-1.0, -1.5, -0.2], [5.0, 1.5, 0.0]];
    let wall = |low: f32, high: f32| [[2.0, low, 0.0], [2.12, high, 2.2]];
    let threshold = [[2.0, -0.5, 0.0], [2.12, 0.5, 0.02]];
    let boxes = [floor, threshold, wall(-1.5, -0.5), wall(0.5, 1.5)];
    fs::write(file("doorway.stl"), stl(&boxes)).unwrap();
    let world = "mu = 0.7\n\n[[shapes]]\nname = \"doorway\"\nmesh = { path = \"doorway.stl\" }\n";
    fs::write(file("world.toml"), world).unwrap();
    let robot = fs::canonicalize("configs/robots/hubo/robot.toml").unwrap();
    let scenario = format!(
        "robot = {robot:?}\nworld = \"world.toml\"\nseed = 1\n[start]\nxyz = [0.0, 0.0, 0.0]\n\
         yaw = 0.0\n[goal]\nxyz = [4.0, 0.5, 0.0]\nyaw = 1.57\n"
    );
    fs::write(file("scenario.toml"), scenario).unwrap();
    let [from, to] = [file("scenario.toml"), file("plan.json")];
    let [from, to] = [from.to_str().unwrap(), to.to_str().unwrap()];
    let planned = run(&["plan", from, "--motion", "smooth", "--quiet", "--export", to]);
    assert_eq!(planned.code, 0, "{}{}", planned.out, planned.err);
    assert_stands(replay(&python, Path::new(to), &[]));
}
