//! Broken robot files, URDFs and meshes: every one gives one clear error.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use common::{FOOT_OBJ, Folder, ROBOT, Spoiling, URDF, check_no_panic, check_spoilings, load};
use surefoot_shared_types::robot::load::load_robot;

#[test]
fn broken_urdfs_are_refused() {
    let hip_limit = "<limit lower=\"-1\" upper=\"1.5\" effort=\"80\" velocity=\"5\"/>";
    let foot_mass = "<mass value=\"2\"/>";
    let cases = [
        Spoiling {
            from: hip_limit,
            to: "",
            complaint: &["stilts.urdf:16: joint 'left_hip'", "no <limit>"],
        },
        Spoiling {
            from: "lower=\"-1\"",
            to: "lower=\"1.5\"",
            complaint: &["joint 'left_hip'", "lock it"],
        },
        Spoiling {
            from: "upper=\"1.5\" effort=\"80\" velocity=\"5\"/>\n  </joint>\n  <joint name=\"imu_mount\"",
            to: "upper=\"1.5\" velocity=\"5\"/>\n  </joint>\n  <joint name=\"imu_mount\"",
            complaint: &["joint 'right_hip'", "has no effort", "[effort_limits]"],
        },
        Spoiling {
            from: "effort=\"80\"",
            to: "effort=\"-1\"",
            complaint: &["joint 'left_hip'", "effort must be positive"],
        },
        Spoiling { from: " velocity=\"5\"", to: "", complaint: &["joint 'left_hip'", "velocity"] },
        Spoiling {
            from: " velocity=\"5\"",
            to: " velocity=\"0\"",
            complaint: &["joint 'left_hip'", "velocity must be positive"],
        },
        Spoiling {
            from: "upper=\"1.5\"",
            to: "upper=\"nan\"",
            complaint: &["stilts.urdf:18", "joint 'left_hip'", "NaN"],
        },
        Spoiling {
            from: "upper=\"1.5\"",
            to: "upper=\"inf\"",
            complaint: &["joint 'left_hip'", "inf"],
        },
        Spoiling {
            from: "0 0.1 0\"",
            to: "0 abc 0\"",
            complaint: &["stilts.urdf:17", "joint 'left_hip'", "not 3 numbers"],
        },
        Spoiling {
            from: "0 0.1 0\"",
            to: "0 0.1 0 0\"",
            complaint: &["joint 'left_hip'", "4 numbers instead of 3"],
        },
        Spoiling {
            from: "0 0.1 0\"",
            to: "0 1e7 0\"",
            complaint: &["joint 'left_hip'", "10000000"],
        },
        Spoiling {
            from: "xyz=\"0 2 0\"",
            to: "xyz=\"0 0 0\"",
            complaint: &["joint 'left_hip'", "axis"],
        },
        Spoiling {
            from: "type=\"revolute\"",
            to: "type=\"floating\"",
            complaint: &["joint 'left_hip'", "only revolute"],
        },
        Spoiling {
            from: "type=\"revolute\"",
            to: "type=\"bendy\"",
            complaint: &["joint 'left_hip'", "unknown type 'bendy'"],
        },
        Spoiling { from: "type=\"revolute\"", to: "", complaint: &["joint 'left_hip'", "no type"] },
        Spoiling {
            from: "<child link=\"left_foot\"/>",
            to: "<child link=\"lost\"/>",
            complaint: &["joint 'left_hip'", "'lost'"],
        },
        Spoiling {
            from: "<parent link=\"pelvis\"/>",
            to: "<parent link=\"lost\"/>",
            complaint: &["joint 'left_hip'", "'lost'"],
        },
        Spoiling {
            from: "<child link=\"left_foot\"/>",
            to: "",
            complaint: &["joint 'left_hip'", "no <child"],
        },
        Spoiling {
            from: "<child link=\"left_foot\"/>",
            to: "<child link=\"right_foot\"/>",
            complaint: &["joint 'right_hip'", "already hangs"],
        },
        Spoiling {
            from: "<child link=\"imu\"/>",
            to: "<child link=\"pelvis\"/>",
            complaint: &["link 'pelvis'", "not on the root"],
        },
        Spoiling {
            from: "<link name=\"imu\"/>",
            to: "<link name=\"imu\"/><link name=\"extra\"/>",
            complaint: &["link 'extra'", "second root"],
        },
        Spoiling {
            from: "<link name=\"imu\"/>",
            to: "<link name=\"pelvis\"/>",
            complaint: &["link 'pelvis'", "same name"],
        },
        Spoiling { from: "<link name=\"imu\"/>", to: "<link/>", complaint: &["<link>", "no name"] },
        Spoiling {
            from: "joint name=\"right_hip\"",
            to: "joint name=\"left_hip\"",
            complaint: &["joint 'left_hip'", "same name"],
        },
        Spoiling {
            from: "meshes/foot.obj",
            to: "meshes/gone.obj",
            complaint: &["link 'right_foot'", "gone.obj", "not found"],
        },
        Spoiling {
            from: foot_mass,
            to: "<mass value=\"0\"/>",
            complaint: &["link 'left_foot'", "no mass"],
        },
        Spoiling {
            from: foot_mass,
            to: "<mass value=\"-2\"/>",
            complaint: &["link 'left_foot'", "negative"],
        },
        Spoiling { from: foot_mass, to: "", complaint: &["stilts.urdf", "mass"] },
        Spoiling {
            from: "ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"",
            to: "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"",
            complaint: &["link 'left_foot'", "positive definite"],
        },
        Spoiling {
            from: "ixx=\"0.02\"",
            to: "ixx=\"-0.02\"",
            complaint: &["link 'left_foot'", "positive definite"],
        },
        Spoiling {
            from: "ixy=\"0\"",
            to: "ixy=\"0.2\"",
            complaint: &["link 'pelvis'", "positive definite"],
        },
        Spoiling {
            from: "size=\"0.2 0.1 0.04\"",
            to: "size=\"0.2 0 0.04\"",
            complaint: &["link 'left_foot'", "box size", "positive"],
        },
        Spoiling {
            from: "radius=\"0.1\"",
            to: "radius=\"-0.1\"",
            complaint: &["link 'pelvis'", "radius", "negative"],
        },
        Spoiling {
            from: "size=\"0.2 0.1 0.04\"",
            to: "size=\"0.18 0.1 0.04\"",
            complaint: &["robot.toml:10", "foot 'left'", "10.0 mm off"],
        },
        Spoiling {
            from: "<axis xyz=\"0 2 0\"/>",
            to: "<axis xyz=\"0 2 0\"/><mimic joint=\"right_hip\"/>",
            complaint: &["joint 'left_hip'", "mimics 'right_hip'", "lock that one"],
        },
        Spoiling { from: "</robot>", to: "", complaint: &["stilts.urdf:"] },
        Spoiling { from: "<robot name=\"stilts\">", to: "<model>", complaint: &["stilts.urdf:"] },
    ];
    check_spoilings("stilts.urdf", URDF, &cases, load);
}

#[test]
fn one_fault_of_a_link_is_one_complaint() {
    for (from, to, complaint) in [
        ("<mass value=\"2\"/>", "<mass value=\"-2\"/>", "must not be negative"),
        ("<mass value=\"2\"/>", "<mass value=\"2 kg\"/>", "is not 1 number"),
        ("<box size=\"0.2 0.1 0.04\"/>", "<mesh filename=\"\"/>", "has no filename"),
        ("<box size=\"0.2 0.1 0.04\"/>", "", "holds 0 shapes"),
        ("<box size=\"0.2 0.1 0.04\"/>", "<box size=\"0.2,0.1,0.04\"/>", "is not 3 numbers"),
        ("<box size=\"0.2 0.1 0.04\"/>", "<box size=\"1e300 1 1\"/>", "holds 1e300; every"),
    ] {
        let folder = Folder::new();
        assert!(URDF.contains(from), "{from}");
        folder.write("stilts.urdf", URDF.replacen(from, to, 1).as_bytes());
        let error = load(folder.path("").as_path()).unwrap_err().to_string();
        assert!(error.contains(complaint), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn a_file_that_is_no_urdf_is_refused() {
    let folder = Folder::new();
    folder.write("stilts.urdf", b"<sdf/>");
    assert!(load(&folder.path("")).unwrap_err().to_string().contains("not a URDF"));
    folder.write("stilts.urdf", b"<robot name=\"r\"/>");
    assert!(load(&folder.path("")).unwrap_err().to_string().contains("no link"));
    let deep =
        format!("<robot name=\"r\">{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    folder.write("stilts.urdf", deep.as_bytes());
    assert!(load(&folder.path("")).unwrap_err().to_string().contains("nested deeper"));
}

#[test]
fn a_cycle_without_a_root_is_refused() {
    let folder = Folder::new();
    let joint = "<joint name=\"back\" type=\"fixed\"><parent link=\"imu\"/><child link=\"pelvis\"/></joint></robot>";
    folder.write("stilts.urdf", URDF.replace("</robot>", joint).as_bytes());
    assert!(load(&folder.path("")).unwrap_err().to_string().contains("cycle"));
}

#[test]
fn too_many_joints_are_refused() {
    let folder = Folder::new();
    let arms: String = (0..50)
        .map(|i| {
            format!(
                "<link name=\"a{i}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\
                 <joint name=\"j{i}\" type=\"prismatic\"><parent link=\"pelvis\"/><child link=\"a{i}\"/>\
                 <limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
            )
        })
        .collect();
    folder.write("stilts.urdf", URDF.replace("</robot>", &format!("{arms}</robot>")).as_bytes());
    let error = load(&folder.path("")).unwrap_err().to_string();
    assert!(error.contains("52 joints move") && error.contains("Lock"), "{error}");
}

#[test]
fn broken_robot_files_are_refused() {
    let polygon = "polygon = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]";
    let cases = [
        Spoiling {
            from: "stilts.urdf",
            to: "gone.urdf",
            complaint: &["gone.urdf", "cannot be read"],
        },
        Spoiling { from: "stilts.urdf", to: ".", complaint: &["is a folder"] },
        Spoiling {
            from: "root = \"pelvis\"",
            to: "root = \"imu\"",
            complaint: &["robot.toml:2", "root", "'pelvis'"],
        },
        Spoiling { from: "root =", to: "roots =", complaint: &["robot.toml:2", "roots"] },
        Spoiling { from: "root = \"pelvis\"", to: "root = ", complaint: &["robot.toml:2"] },
        Spoiling {
            from: "root = \"pelvis\"",
            to: "exact_meshes = [\"lost\"]",
            complaint: &["robot.toml:2", "exact_meshes", "'lost'"],
        },
        Spoiling {
            from: "name = \"right\"",
            to: "name = \"middle\"",
            complaint: &["feet", "middle"],
        },
        Spoiling {
            from: "name = \"right\"",
            to: "name = \"left\"",
            complaint: &["feet", "exactly one"],
        },
        Spoiling {
            from: "link = \"right_foot\"",
            to: "link = \"lost\"",
            complaint: &["robot.toml:4", "foot 'right'", "'lost'"],
        },
        Spoiling {
            from: "link = \"right_foot\"",
            to: "link = \"imu\"",
            complaint: &["foot 'right'", "off the collision shapes of link 'pelvis'"],
        },
        Spoiling {
            from: "sole_xyz = [0, 0, -1.0]",
            to: "sole_xyz = [0, 0, -1.01]",
            complaint: &["foot 'right'", "10.0 mm off"],
        },
        Spoiling {
            from: "sole_xyz = [0, 0, -1.0]",
            to: "sole_xyz = [0, 0, nan]",
            complaint: &["robot.toml:4", "foot 'right'", "NaN"],
        },
        Spoiling {
            from: "sole_xyz = [0, 0, -1.0]",
            to: "sole_xyz = [0, 0]",
            complaint: &["robot.toml:7"],
        },
        Spoiling {
            from: polygon,
            to: "polygon = [[0, 0], [0.1, 0], [0.05, 0]]",
            complaint: &["foot 'right'", "degenerate"],
        },
        Spoiling { from: polygon, to: "polygon = []", complaint: &["foot 'right'", "degenerate"] },
        Spoiling {
            from: polygon,
            to: "polygon = [[0, 0], [7, 0], [0, 1]]",
            complaint: &["foot 'right'", "7 m"],
        },
        Spoiling {
            from: "sole_xyz = [0, 0, -1.0]",
            to: "sole_xyz = [0, 0, -1.0]\nsole_rpy = [0, 0, 3.14]",
            complaint: &["robot.toml:4", "foot 'right'", "180 degrees off", "'pelvis'"],
        },
        Spoiling {
            from: "left_hip = 0.3",
            to: "left_hop = 0.3",
            complaint: &["robot.toml:17", "[standing] 'left_hop'", "no joint"],
        },
        Spoiling {
            from: "left_hip = 0.3",
            to: "imu_mount = 0.3",
            complaint: &["[standing] 'imu_mount'", "fixed"],
        },
        Spoiling {
            from: "left_hip = 0.3",
            to: "left_hip = 2",
            complaint: &["robot.toml:17", "[standing] 'left_hip'", "-1..1.5"],
        },
        Spoiling {
            from: "left_hip = 0.3",
            to: "left_hip = inf",
            complaint: &["[standing] 'left_hip'", "inf"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "left_hip = 90",
            complaint: &["robot.toml:20", "[effort_limits] 'left_hip'", "80"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "left_hip = 0",
            complaint: &["[effort_limits] 'left_hip'", "positive"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "hip = 7",
            complaint: &["[effort_limits] 'hip'", "no joint"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "[locked]\nleft_hip = 0.1",
            complaint: &["[standing] 'left_hip'", "locked"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "[locked]\nright_hip = 0.1",
            complaint: &["[locked] 'right_hip'", "0.2..1.5"],
        },
        Spoiling {
            from: "left_hip = 70",
            to: "[locked]\nhip = 0.1",
            complaint: &["[locked] 'hip'", "no joint"],
        },
    ];
    check_spoilings("robot.toml", ROBOT, &cases, load);
}

#[test]
fn a_sole_of_too_many_corners_is_refused() {
    let folder = Folder::new();
    let circle: Vec<[f64; 2]> = (0..40)
        .map(|i| libm::sincos(f64::from(i) * 0.157))
        .map(|(sin, cos)| [0.05 * cos, 0.05 * sin])
        .collect();
    let polygon = "polygon = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]";
    folder.write(
        "robot.toml",
        ROBOT.replacen(polygon, &format!("polygon = {circle:?}"), 1).as_bytes(),
    );
    let error = load(&folder.path("")).unwrap_err().to_string();
    assert!(error.contains("at most 16"), "{error}");
}

#[test]
fn broken_meshes_are_refused() {
    let cases = [
        Spoiling { from: "f 1 4 3", to: "f 1 4 30", complaint: &["link 'right_foot'", "foot.obj"] },
        Spoiling {
            from: "v -0.1 -0.05 -0.02",
            to: "v -0.1 nan -0.02",
            complaint: &["link 'right_foot'", "foot.obj"],
        },
        Spoiling {
            from: "v -0.1 -0.05 -0.02",
            to: "v 1e9 0 0",
            complaint: &["link 'right_foot'", "foot.obj", "beyond"],
        },
        Spoiling { from: FOOT_OBJ, to: "", complaint: &["link 'right_foot'", "foot.obj"] },
        Spoiling {
            from: FOOT_OBJ,
            to: "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            complaint: &["link 'right_foot'", "one plane"],
        },
    ];
    check_spoilings("meshes/foot.obj", FOOT_OBJ, &cases, load);
}

#[test]
fn no_damage_panics() {
    check_no_panic("stilts.urdf", URDF.as_bytes(), load);
    check_no_panic("robot.toml", ROBOT.as_bytes(), load);
    check_no_panic("meshes/foot.obj", FOOT_OBJ.as_bytes(), load);
}

/// What a file of this content is refused with, in place of each text file of a robot.
fn refusals(bytes: &[u8]) -> [String; 2] {
    ["robot.toml", "stilts.urdf"].map(|file| {
        let folder = Folder::new();
        folder.write(file, bytes);
        load_robot(&folder.path("robot.toml")).map(|_| ()).unwrap_err().to_string()
    })
}

#[test]
fn files_that_are_no_text_of_their_kind_are_called_what_they_are() {
    let wide: Vec<u8> = ROBOT.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (bytes, expected) in [
        (&b""[..], "is empty"),
        (b" \n\r\n", "is empty"),
        (&[b"\xff\xfe", &wide[..]].concat(), "is UTF-16 text; save it as UTF-8"),
        (&wide, "is UTF-16 text; save it as UTF-8"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d\n", "git lfs pull"),
        (b"\x1f\x8b\x08\0abc", "is a compressed file"),
    ] {
        for error in refusals(bytes) {
            assert!(error.contains(expected) && error.lines().count() == 1, "{error}");
        }
    }
    let [robot, urdf] = refusals(b"robot:\n  name: stilts\n");
    assert!(robot.contains("robot.toml:1") && urdf.contains("is not XML"), "{robot} {urdf}");
    let [robot, _] = refusals(b"<!DOCTYPE html><html>404</html>");
    assert!(robot.contains("is a web page"), "{robot}");
}

#[test]
fn a_link_that_leads_nowhere_is_named() {
    for target in ["gone.toml", "robot.toml"] {
        let folder = Folder::new();
        std::fs::remove_file(folder.path("robot.toml")).unwrap();
        std::os::unix::fs::symlink(target, folder.path("robot.toml")).unwrap();
        let error = load_robot(&folder.path("robot.toml")).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(&format!("link to '{target}'")), "{error}");
    }
}
