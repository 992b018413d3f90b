//! Broken robot files, URDFs and meshes: every one gives one clear error.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use common::{FOOT_OBJ, Folder, ROBOT, URDF, check_no_panic, check_spoilings, load};
use surefoot_shared_types::robot::load::load_robot;

#[test]
fn broken_urdfs_are_refused() {
    let cases = include_str!("data/broken_urdf.txt");
    check_spoilings("stilts.urdf", URDF, cases, load);
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
    let cases = include_str!("data/broken_robot_file.txt");
    check_spoilings("robot.toml", ROBOT, cases, load);
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
    let cases = include_str!("data/broken_mesh.txt");
    check_spoilings("meshes/foot.obj", FOOT_OBJ, cases, load);
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
