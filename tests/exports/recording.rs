//! Recordings: read back by the format's definition, and by its libraries where Python has them.

use std::collections::BTreeMap;

use surefoot::export::{ExportFormat, ExportOptions};

use crate::command::run;
use crate::libraries::{python_with, run_script};
use crate::mcap_reader::McapFile;
use crate::plan::{MOTION, exported, options};
use crate::ros_reader::{Schema, Value};

const HZ: f64 = 2.0;

fn recording() -> Vec<u8> {
    exported(&ExportOptions { hz: Some(HZ), ..options(ExportFormat::Mcap) })
}

/// The messages of a topic, decoded by the schema in the file.
fn messages(file: &McapFile, topic: &str) -> Vec<(u64, BTreeMap<String, Value>)> {
    let (channel, schema) = file.channel(topic);
    let schema = Schema::new(&schema.1);
    let own = file.messages.iter().filter(|message| message.channel == channel);
    own.map(|message| (message.time, schema.decode(&message.data))).collect()
}

#[test]
fn a_recording_holds_what_it_declares() {
    let bytes = recording();
    assert!(bytes == recording(), "the same plan gives the same bytes");
    let file = McapFile::read(&bytes);
    assert_eq!(file.profile, "ros2");
    let topics: Vec<&str> = file.channels.values().map(|(topic, _)| topic.as_str()).collect();
    for topic in ["/joint_trajectory", "/root_trajectory", "/tf", "/scene", "/footsteps"] {
        assert!(topics.contains(&topic), "{topics:?}");
    }
    let plan = &MOTION.origin.as_ref().unwrap().plan;
    assert_eq!(&file.metadata["plan_digest"], plan);
    assert!(file.messages.is_sorted_by(|a, b| a.time <= b.time));
    for topic in topics {
        assert!(!messages(&file, topic).is_empty(), "{topic}");
    }
}

#[test]
fn joint_states_and_trajectories_are_those_of_the_plan() {
    let file = McapFile::read(&recording());
    let joints = MOTION.model.joints.len();
    let trajectory = &messages(&file, "/joint_trajectory")[0].1;
    let points = trajectory["points"].list();
    assert_eq!(points.len(), MOTION.waypoints.len());
    for (point, waypoint) in points.iter().zip(&MOTION.waypoints) {
        assert_eq!(point.field("positions").numbers(), waypoint.q[..joints]);
        let time = point.field("time_from_start");
        let seconds = time.field("sec").number() + 1e-9 * time.field("nanosec").number();
        assert!((seconds - (waypoint.time - MOTION.span().0)).abs() < 1e-9);
    }
    let states = messages(&file, "/joint_states");
    let (begin, end) = MOTION.span();
    assert_eq!(states.len(), libm::ceil((end - begin) * HZ - 1e-9) as usize + 1);
    for (time, state) in &states {
        let sample = MOTION.sample(begin + *time as f64 * 1e-9);
        assert_eq!(state["name"].list().len(), joints + MOTION.model.locked_joints.len());
        let positions = state["position"].numbers();
        assert!(positions.iter().zip(&sample.q[..joints]).all(|(a, b)| (a - b).abs() < 1e-7));
    }
}

#[test]
fn the_frames_form_one_tree_and_the_feet_carry_the_weight() {
    let file = McapFile::read(&recording());
    let mut parents: BTreeMap<String, String> = BTreeMap::new();
    for topic in ["/tf", "/tf_static"] {
        for transform in messages(&file, topic)[0].1["transforms"].list() {
            let child = transform.field("child_frame_id").text().to_owned();
            let parent = transform.field("header").field("frame_id").text().to_owned();
            assert!(parents.insert(child, parent).is_none(), "a frame has two parents");
        }
    }
    assert_eq!(parents.len(), MOTION.model.links.len() + MOTION.model.feet.len());
    let is_world = |frame: &String| {
        let mut frame = frame.clone();
        for _ in 0..parents.len() {
            let Some(parent) = parents.get(&frame) else { break };
            frame.clone_from(parent);
        }
        frame == "world"
    };
    assert!(parents.keys().all(is_world));
    let force = |message: &BTreeMap<String, Value>| {
        let force = message["wrench"].field("force");
        ["x", "y", "z"].map(|axis| force.field(axis).number())
    };
    let [left, right] =
        ["left", "right"].map(|foot| messages(&file, &format!("/contact_wrench/{foot}")));
    let weight = MOTION.model.mass() * 9.81;
    for ((_, left), (_, right)) in left.iter().zip(&right) {
        let total = force(left)[2] + force(right)[2];
        assert!((total - weight).abs() < 2e-3 * weight, "{total} of {weight} N on level soles");
    }
}

#[test]
fn walks_and_plans_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.mcap");
    let record = path.to_str().unwrap();
    for command in ["plan", "walk"] {
        let scenario = "configs/scenarios/ibeam_gap.toml";
        let motion = ["--motion", "quasi_static"];
        let arguments = [&[command, scenario, "--quiet", "--record", record], &motion[..]].concat();
        let output = run(&arguments);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
        let file = McapFile::read(&std::fs::read(&path).unwrap());
        assert_eq!(file.metadata["plan_digest"], MOTION.origin.as_ref().unwrap().plan);
        std::fs::remove_file(&path).unwrap();
    }
}

#[test]
fn the_formats_own_libraries_read_the_recording() {
    let modules = ["mcap", "mcap_ros2", "rosbags", "numpy"];
    let Some(python) = python_with(&modules) else { return };
    let folder = tempfile::tempdir().unwrap();
    let [recording_path, contacts] =
        ["walk.mcap", "contacts.json"].map(|name| folder.path().join(name));
    std::fs::write(&recording_path, recording()).unwrap();
    let sequence = ExportOptions { hz: Some(HZ), ..options(ExportFormat::Contacts) };
    std::fs::write(&contacts, exported(&sequence)).unwrap();
    run_script(&python, "tests/exports/check_mcap.py", &[&recording_path, &contacts]);
}
