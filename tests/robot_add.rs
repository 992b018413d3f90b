//! `surefoot robot`: from a URDF alone to a robot that walks.

#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::run;
use serde_json::Value;

/// A folder with the shipped URDF alone.
struct UrdfFolder(tempfile::TempDir);

impl UrdfFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo/hubo.urdf");
        fs::copy(urdf, folder.path().join("hubo.urdf")).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }
}

#[test]
fn a_urdf_alone_becomes_a_robot_that_walks() {
    let folder = UrdfFolder::new();
    let (urdf, out) = (folder.path("hubo.urdf"), folder.path("mine"));
    let added = run(&["robot", "add", &urdf, "--out", &out, "--quiet"]);
    assert_eq!(added.code, 0, "{}{}", added.out, added.err);
    for part in ["27 joints move", "left_foot: 220 x 140 mm", "a metre of level ground", "next:"] {
        assert!(added.out.contains(part), "'{part}' is not in: {}", added.out);
    }
    let file = folder.path("mine/robot.toml");
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("urdf = \"../hubo.urdf\""), "{text}");

    let again = run(&["robot", "add", &urdf, "--out", &out, "--quiet"]);
    assert_eq!(again.code, 2, "{}", again.out);
    assert!(again.err.contains("it exists"), "{}", again.err);
    assert_eq!(fs::read_to_string(&file).unwrap(), text);

    let picture = folder.path("robot.png");
    let inspected = run(&["robot", "inspect", &out, "--picture", &picture, "--json"]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    let report: Value = serde_json::from_str(&inspected.out).unwrap();
    assert_eq!(report["joints"].as_array().unwrap().len(), 27);
    assert_eq!(report["feet"][0]["leg"].as_array().unwrap().len(), 6);
    assert!(!report["allowed_pairs"].as_array().unwrap().is_empty());
    assert!(fs::read(&picture).unwrap().starts_with(b"\x89PNG"));

    let first = folder.path("first");
    let made = run(&["new", &first, "--robot", &file]);
    assert_eq!(made.code, 0, "{}", made.err);
    let walked = run(&["walk", &folder.path("first/scenario.toml"), "--quiet"]);
    assert_eq!(walked.code, 0, "{}{}", walked.out, walked.err);
}

#[test]
fn a_urdf_is_inspected_without_a_robot_file() {
    let folder = UrdfFolder::new();
    let inspected = run(&["robot", "inspect", &folder.path("hubo.urdf")]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    for part in ["58.", "left_knee", "may touch", "sole of 4 corners and 308.0 cm2"] {
        assert!(inspected.out.contains(part), "'{part}' is not in: {}", inspected.out);
    }
}

#[test]
fn nothing_is_left_where_a_robot_cannot_be_added() {
    let folder = UrdfFolder::new();
    let text = fs::read_to_string(folder.path("hubo.urdf")).unwrap();
    let broken = text.replacen("<box size=\"0.1 0.2 0.12\"/>", "<mesh filename=\"gone.stl\"/>", 1);
    assert_ne!(broken, text);
    fs::write(folder.path("hubo.urdf"), broken).unwrap();
    let out = folder.path("deep/mine");
    let added = run(&["robot", "add", &folder.path("hubo.urdf"), "--out", &out]);
    assert_eq!(added.code, 2, "{}", added.out);
    assert!(added.err.contains("hubo.urdf:21: link 'pelvis': mesh 'gone.stl'"), "{}", added.err);
    assert!(!Path::new(&folder.path("deep")).exists());
}
