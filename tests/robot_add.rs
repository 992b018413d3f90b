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

#[test]
fn a_package_that_is_called_otherwise_is_named_on_the_command_line() {
    let folder = UrdfFolder::new();
    let text = fs::read_to_string(folder.path("hubo.urdf")).unwrap();
    let mesh = "<mesh filename=\"package://hubo_data/pelvis.stl\"/>";
    let urdf = text.replacen("<box size=\"0.1 0.2 0.12\"/>", mesh, 1);
    fs::create_dir(folder.path("hubo_data")).unwrap();
    fs::create_dir(folder.path("urdf")).unwrap();
    fs::write(folder.path("urdf/hubo.urdf"), urdf).unwrap();
    fs::write(folder.path("hubo_data/package.xml"), "<package><name>data</name></package>")
        .unwrap();
    fs::write(folder.path("hubo_data/pelvis.stl"), box_stl([0.05, 0.1, 0.06])).unwrap();
    let (urdf, out) = (folder.path("urdf/hubo.urdf"), folder.path("mine"));

    let refused = run(&["robot", "add", &urdf, "--out", &out, "--quiet"]);
    assert_eq!(refused.code, 2, "{}", refused.out);
    for part in ["says 'data'", "--package hubo_data=DIR"] {
        assert!(refused.err.contains(part), "{}", refused.err);
    }
    let package = format!("hubo_data={}", folder.path("hubo_data"));
    let added = run(&["robot", "add", &urdf, "--out", &out, "--quiet", "--package", &package]);
    assert_eq!(added.code, 0, "{}{}", added.out, added.err);
    let file = fs::read_to_string(folder.path("mine/robot.toml")).unwrap();
    assert!(file.contains("[packages]\nhubo_data = \"../hubo_data\""), "{file}");

    // An exported plan carries it on.
    let (first, plan) = (folder.path("first"), folder.path("plans/plan.json"));
    fs::create_dir(folder.path("plans")).unwrap();
    assert_eq!(run(&["new", &first, "--robot", &folder.path("mine/robot.toml")]).code, 0);
    let scenario = folder.path("first/scenario.toml");
    let planned = run(&["plan", &scenario, "--quiet", "--export", &plan]);
    assert_eq!(planned.code, 0, "{}{}", planned.out, planned.err);
    fs::remove_file(folder.path("mine/robot.toml")).unwrap();
    let checked = run(&["check", &plan]);
    assert_eq!(checked.code, 0, "{}{}", checked.out, checked.err);
}

/// A box as binary STL.
fn box_stl([x, y, z]: [f32; 3]) -> Vec<u8> {
    let corner = |at: usize| {
        let sign = |bit: usize| if at >> bit & 1 == 1 { 1.0 } else { -1.0 };
        [x * sign(0), y * sign(1), z * sign(2)]
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let mut bytes = vec![0; 80];
    bytes.extend(12_u32.to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        face.iter()
            .for_each(|at| corner(**at).iter().for_each(|it| bytes.extend(it.to_le_bytes())));
        bytes.extend([0; 2]);
    }
    bytes
}
