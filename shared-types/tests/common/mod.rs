//! A small valid robot, world and scenario, for tests to change.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]
#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::path::{Path, PathBuf};

use surefoot_shared_types::InputError;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;

/// The robot of a folder.
pub fn load(folder: &Path) -> Result<RobotModel, InputError> {
    load_robot(&folder.join("robot.toml"))
}

/// A biped of two one-joint legs. The sole is the underside of a box.
pub const URDF: &str = r#"<?xml version="1.0"?>
<robot name="stilts">
  <link name="pelvis">
    <inertial><mass value="10"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="left_foot">
    <inertial><origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <collision><origin xyz="0 0 -0.98"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision>
  </link>
  <link name="right_foot">
    <inertial><origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <collision><origin xyz="0 0 -0.98"/><geometry><mesh filename="package://stilts/meshes/foot.obj"/></geometry></collision>
  </link>
  <link name="imu"/>
  <joint name="left_hip" type="revolute">
    <origin xyz="0 0.1 0"/><parent link="pelvis"/><child link="left_foot"/><axis xyz="0 2 0"/>
    <limit lower="-1" upper="1.5" effort="80" velocity="5"/>
  </joint>
  <joint name="right_hip" type="revolute">
    <origin xyz="0 -0.1 0"/><parent link="pelvis"/><child link="right_foot"/><axis xyz="0 1 0"/>
    <limit lower="0.2" upper="1.5" effort="80" velocity="5"/>
  </joint>
  <joint name="imu_mount" type="fixed"><parent link="pelvis"/><child link="imu"/></joint>
</robot>
"#;

/// The robot file of [`URDF`].
pub const ROBOT: &str = r#"urdf = "stilts.urdf"
root = "pelvis"

[[feet]]
name = "right"
link = "right_foot"
sole_xyz = [0, 0, -1.0]
polygon = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]

[[feet]]
name = "left"
link = "left_foot"
sole_xyz = [0, 0, -1.0]
polygon = [[0.1, 0.05], [0.1, -0.05], [0.0, -0.05], [-0.1, -0.05], [-0.1, 0.05]]

[standing]
left_hip = 0.3

[effort_limits]
left_hip = 70

[accelerations]
left_hip = 30
"#;

/// A world of every kind of shape.
pub const WORLD: &str = r#"mu = 0.6

[[shapes]]
name = "floor"
xyz = [0, 0, -0.25]
box = { half_extents = [5, 1, 0.25] }

[[shapes]]
name = "ball"
sphere = { radius = 0.1 }

[[shapes]]
name = "pipe"
rpy = [1.5707963267948966, 0, 0]
cylinder = { radius = 0.05, length = 2 }

[[shapes]]
name = "rail"
quat_xyzw = [0, 0, 0, 1]
capsule = { radius = 0.05, length = 2 }

[[shapes]]
name = "wedge"
convex = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] }

[[shapes]]
name = "block"
mesh = { path = "meshes/foot.obj", scale = [1, -1, 2] }
"#;

/// A scenario with margins of its own.
pub const SCENARIO: &str = r#"robot = "robot.toml"
world = "world.toml"
seed = 7

[start]
xyz = [0, 0, 0]

[goal]
xyz = [3, 0, 0]
yaw = 1.5
stance_width = 0.3

[planner]
work_max = 1000
com_margin = 0.02

[checker]
com_margin = 0.001
"#;

/// A box of 0.2 x 0.1 x 0.04 as an OBJ file.
pub const FOOT_OBJ: &str = "v -0.1 -0.05 -0.02\nv 0.1 -0.05 -0.02\nv 0.1 0.05 -0.02\nv -0.1 0.05 -0.02\n\
v -0.1 -0.05 0.02\nv 0.1 -0.05 0.02\nv 0.1 0.05 0.02\nv -0.1 0.05 0.02\n\
f 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

/// A folder with all of the above in it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// A new folder with these valid files.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(folder.path("meshes")).unwrap();
        for (name, text) in [
            ("stilts.urdf", URDF),
            ("robot.toml", ROBOT),
            ("world.toml", WORLD),
            ("scenario.toml", SCENARIO),
            ("meshes/foot.obj", FOOT_OBJ),
        ] {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Overwrites a file in it.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }
}

/// Spoils `file` in one way after the other and checks that loading complains in lines that
/// name the file. A line of `cases` holds a text, its replacement and parts of the error, parted by
/// ` | `; `\n` is a line break, and `<all>` the whole file.
pub fn check_spoilings<T: std::fmt::Debug>(
    file: &str,
    good: &str,
    cases: &str,
    load: impl Fn(&Path) -> Result<T, InputError>,
) {
    for case in cases.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = case.split(" | ").collect();
        let [from, to, complaint @ ..] = &fields[..] else { panic!("{case}") };
        assert!(!complaint.is_empty(), "{case}");
        let [from, to] = [from, to].map(|text| text.replace("\\n", "\n"));
        let from = if from == "<all>" { good } else { from.as_str() };
        let folder = Folder::new();
        assert!(good.contains(from), "{file} does not contain {from}");
        folder.write(file, good.replacen(from, &to, 1).as_bytes());
        let error = match load(folder.path("").as_path()) {
            Ok(loaded) => panic!("{case} was accepted: {loaded:?}"),
            Err(error) => error.to_string(),
        };
        // One complaint a line; one mistake may have several.
        assert!(error.lines().skip(1).all(|line| line.starts_with("error: ")), "{error}");
        for part in complaint {
            assert!(error.contains(part), "{case}: '{part}' is not in: {error}");
        }
    }
}

/// Truncates `good` at many offsets and flips many of its bits. Loading may fail, but not panic.
pub fn check_no_panic<T>(file: &str, good: &[u8], load: impl Fn(&Path) -> Result<T, InputError>) {
    let folder = Folder::new();
    let stride = (good.len() / 150).max(1);
    for at in (0..good.len()).step_by(stride) {
        folder.write(file, &good[..at]);
        let _ = load(folder.path("").as_path());
        for flipped in [0x01, 0x10, 0x80] {
            let mut bytes = good.to_vec();
            bytes[at] ^= flipped;
            folder.write(file, &bytes);
            let _ = load(folder.path("").as_path());
        }
    }
}
