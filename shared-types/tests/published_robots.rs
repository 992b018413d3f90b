//! Robots as programs and people publish them are read, and no robot is refused for what planning
//! does not need; all errors are reported at once, with their places.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use std::path::Path;

use common::{FOOT_OBJ, Folder, ROBOT, URDF};
use glam::DVec3;
use surefoot_shared_types::robot::load::{impossible_inertias, load_robot};
use surefoot_shared_types::robot::model::RobotModel;

const HIP_LIMIT: &str = "<limit lower=\"-1\" upper=\"1.5\" effort=\"80\" velocity=\"5\"/>";

fn load(urdf: &str, robot: &str) -> Result<RobotModel, String> {
    load_in(&Folder::new(), urdf, robot)
}

fn load_in(folder: &Folder, urdf: &str, robot: &str) -> Result<RobotModel, String> {
    folder.write("stilts.urdf", urdf.as_bytes());
    folder.write("robot.toml", robot.as_bytes());
    load_robot(&folder.path("robot.toml")).map_err(|error| error.to_string())
}

/// [`URDF`] with one thing changed, which must be there.
fn changed(from: &str, to: &str) -> String {
    assert!(URDF.contains(from), "{from}");
    URDF.replacen(from, to, 1)
}

/// Both are read in one folder, because a shape names the file that it was read from.
fn assert_same_robot(urdf: &str) -> RobotModel {
    let folder = Folder::new();
    let plain = load_in(&folder, URDF, ROBOT).unwrap();
    let robot = load_in(&folder, urdf, ROBOT).unwrap_or_else(|e| panic!("{e}: {urdf}"));
    assert_eq!((&robot.links, &robot.feet), (&plain.links, &plain.feet), "{urdf}");
    robot
}

#[test]
fn xml_and_elements_of_other_programs_change_nothing() {
    for urdf in [
        format!("\n\n{URDF}"),
        format!("<!-- made by a program -->\n{URDF}"),
        format!("\u{feff}{URDF}"),
        changed("<robot name", "<!DOCTYPE robot>\n<robot name"),
        changed(
            "<link name=\"imu\"/>",
            "<link name=\"imu\"/><!-- --- imu --- --><sim:contact sim:value=\"1\"/>",
        ),
        changed(
            "<link name=\"pelvis\">",
            "<link name=\"pelvis\" sim:kind=\"trunk\" concave=\"yes\">",
        ),
        changed("<robot name=\"stilts\">", "<robot name=\"stilts\" version=\"1.2\">"),
        changed(
            "velocity=\"5\"/>",
            "velocity=\"5\" stiffness=\"x\"/><dynamics damping=\"\"/><dynamics/><calibration rising=\"\"/><safety_controller k=\"\"/>",
        ),
        changed(
            "</collision>",
            "<verbose value=\"x\"/></collision><visual><geometry/></visual><sensor/>",
        ),
        changed(
            "type=\"fixed\"><parent link=\"pelvis\"/>",
            "type=\"fixed\"><axis xyz=\"0 0 0\"/><limit lower=\"x\"/><mimic joint=\"gone\"/><parent link=\"pelvis\"/>",
        ),
        changed(
            "</robot>",
            "<transmission name=\"t\"><joint name=\"left_hip\"/></transmission><gazebo/></robot>",
        ),
        changed("velocity=\"5\"/>", "velocity=\"5\"/><mimic joint=\"gone\"/>"),
        changed("velocity=\"5\"/>", "velocity=\"5\"/><mimic/>"),
        changed(
            "<link name=\"pelvis\">",
            "<link name=\"world\"/><joint name=\"float\" type=\"floating\"><parent link=\"world\"/><child link=\"pelvis\"/></joint><link name=\"pelvis\">",
        ),
    ] {
        assert_same_robot(&urdf);
    }
}

#[test]
fn a_robot_without_a_name_has_its_files() {
    for nameless in ["<robot>", "<robot name=\"\">"] {
        let robot = assert_same_robot(&changed("<robot name=\"stilts\">", nameless));
        assert_eq!(robot.name, "stilts");
    }
}

#[test]
fn numbers_that_mean_no_limit_are_taken() {
    let limits = |lower: &str, upper: &str, effort: &str, velocity: &str| {
        let limit = format!(
            "<limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"{velocity}\"/>"
        );
        load(&changed(HIP_LIMIT, &limit), &ROBOT.replace("left_hip = 70", "right_hip = 70"))
            .map(|robot| robot.joints[0].clone())
    };
    for none in ["1e9", "50000000", "inf", "1e308", "1e999"] {
        let joint = limits("-1", "1.5", none, none).unwrap();
        assert_eq!((joint.effort, joint.velocity), (1e6, 1e6), "{none}");
    }
    for (lower, upper) in [("-1e16", "1e16"), ("-inf", "inf"), ("-1e9", "1e10")] {
        let joint = limits(lower, upper, "80", "5").unwrap();
        assert_eq!((joint.lower, joint.upper), (-std::f64::consts::PI, std::f64::consts::PI));
    }
    for (lower, upper, effort, velocity) in [
        ("-1", "inf", "80", "5"),
        ("-1", "1.5", "-1e9", "5"),
        ("-1", "1.5", "80", "nan"),
        ("-1", "1.5", "x", "5"),
    ] {
        let error = limits(lower, upper, effort, velocity).unwrap_err();
        assert!(error.contains("stilts.urdf:18: joint 'left_hip'"), "{error}");
    }
}

#[test]
fn joints_that_do_not_move_need_no_limits() {
    let locked = ROBOT.replace("[standing]\nleft_hip = 0.3", "[locked]\nleft_hip = 0.3");
    for limit in [
        "",
        "<limit/>",
        "<limit lower=\"-1\" upper=\"1\"/>",
        "<limit lower=\"-1\" upper=\"1\" effort=\"80\"/>",
    ] {
        let robot = ROBOT.replace("left_hip = 70", "right_hip = 70");
        assert!(load(&changed(HIP_LIMIT, limit), &robot).is_err(), "{limit}");
        load(&changed(HIP_LIMIT, limit), &locked).unwrap_or_else(|e| panic!("{e}: {limit}"));
    }
    // What the URDF leaves open the robot file may say.
    let open = changed(HIP_LIMIT, "<limit lower=\"-1\" upper=\"1.5\" velocity=\"5\"/>");
    assert_eq!(load(&open, ROBOT).unwrap().joints[0].effort, 70.0);
}

#[test]
fn attributes_of_urdf_1_1_and_1_2_are_used_or_refused() {
    let box_origin = "<origin xyz=\"0 0 -0.98\"/><geometry><box";
    let turned = |attribute: &str| {
        let urdf =
            changed(box_origin, &format!("<origin xyz=\"0 0 -0.98\" {attribute}/><geometry><box"));
        load(&urdf, ROBOT).map(|robot| robot.links[1].shapes[0].link_from_shape.rotation * DVec3::X)
    };
    let [by_rpy, by_quaternion] =
        ["rpy=\"0 0 3.141592653589793\"", "quat_xyzw=\"0 0 1 0\""].map(turned);
    assert!((by_rpy.unwrap() - by_quaternion.unwrap()).length() < 1e-12);
    assert!(turned("quat_xyzw=\"0 0 0.7071 0.7071\"").unwrap_err().contains("sole corner"));
    for (bad, part) in [
        ("rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\"", "both"),
        ("quat_xyzw=\"0 0 0 0\"", "length 0"),
        ("quat_xyzw=\"0 0 1\"", "3 numbers instead of 4"),
        ("rpyy=\"0 0 0\"", "is rpy meant?"),
    ] {
        let error = turned(bad).unwrap_err();
        assert!(
            error.contains("stilts.urdf:9: link 'left_foot'") && error.contains(part),
            "{error}"
        );
    }
    let robot = ROBOT.replace("[accelerations]\nleft_hip = 30\n", "");
    let limited = |attribute: &str, robot: &str| {
        let limit = HIP_LIMIT.replace("/>", &format!(" {attribute}/>"));
        load(&changed(HIP_LIMIT, &limit), robot).map(|robot| robot.joints[0].stated_acceleration)
    };
    for (attribute, acceleration) in [
        ("acceleration=\"2\"", Some(2.0)),
        ("deceleration=\"3\"", Some(3.0)),
        ("acceleration=\"20\" deceleration=\"15\"", Some(15.0)),
        ("acceleration=\"10\"", Some(10.0)),
        ("acceleration=\"1e9\"", None),
        ("jerk=\"inf\"", None),
    ] {
        assert_eq!(limited(attribute, &robot), Ok(acceleration), "{attribute}");
    }
    assert_eq!(limited("acceleration=\"40\"", ROBOT), Ok(Some(30.0)));
    for (bad, robot, part) in [
        ("jerk=\"100\"", robot.as_str(), "jerk"),
        ("acceleration=\"0\"", &robot, "must be positive"),
        ("acceleration=\"x\"", &robot, "not 1 number"),
        ("acceleration=\"2\"", ROBOT, "at most the URDF's 2"),
        ("accelerations=\"2\"", &robot, "is acceleration meant?"),
    ] {
        let error = limited(bad, robot).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
    for version in ["2.0", "1.3", "x"] {
        let urdf = changed("<robot name", &format!("<robot version=\"{version}\" name"));
        assert!(load(&urdf, ROBOT).unwrap_err().contains("versions up to 1.2"));
    }
}

#[test]
fn every_mistake_of_a_robot_is_reported_at_once() {
    let urdf = URDF
        .replacen("<mass value=\"10\"/>", "", 1)
        .replacen("size=\"0.2 0.1 0.04\"", "size=\"0.2 0.1\"", 1)
        .replacen("package://stilts/meshes/foot.obj", "meshes/gone.stl", 1)
        .replacen("<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 x 0\"/>", 1)
        .replacen("lower=\"0.2\" upper=\"1.5\"", "lower=\"2\" upper=\"1.5\"", 1)
        .replacen("<child link=\"imu\"/>", "<child link=\"lost\"/>", 1);
    let robot = ROBOT.replace("[standing]\n", "[standing]\nhop = 1\nskip = 2\n");
    let error = load(&urdf, &robot).unwrap_err();
    for place in [
        "robot.toml:17: [standing] 'hop'",
        "robot.toml:18: [standing] 'skip'",
        "stilts.urdf:4: link 'pelvis'",
        "stilts.urdf:9: link 'left_foot'",
        "stilts.urdf:13: link 'right_foot'",
        "stilts.urdf:17: joint 'left_hip'",
        "stilts.urdf:22: joint 'right_hip'",
        "stilts.urdf:24: joint 'imu_mount'",
    ] {
        assert!(error.contains(place), "'{place}' is not in:\n{error}");
    }
    assert_eq!(error.lines().count(), 8, "{error}");
}

#[test]
fn mistyped_elements_are_not_passed_over() {
    for (from, to, part) in [
        ("<collision><origin", "<colision><origin", "is <collision> meant?"),
        ("<collision>", "<Collision>", "is <collision> meant?"),
        ("<link name=\"imu\"/>", "<link name=\"imu\"/><Link name=\"b\"/>", "is <link> meant?"),
        ("ixx=\"0.1\"", "xx=\"0.1\"", "is ixx meant?"),
        ("<collision>", "<collision><orgin/>", "is <origin> meant?"),
        ("<geometry><sphere", "<geometry><ball/><sphere", "holds 2 shapes"),
        ("<sphere radius=\"0.1\"/>", "<plane/>", "<plane>"),
        ("<sphere radius=\"0.1\"/>", "<sphere/>", "has no radius"),
        ("<collision>", "<collision/><collision>", "no <geometry>"),
        ("<mass value=\"10\"/>", "<mass value=\"10\"/><mass value=\"1\"/>", "second <mass>"),
    ] {
        let mut urdf = changed(from, to);
        if to.contains("olision>") && to.contains("origin") || to == "<Collision>" {
            let tag = if to == "<Collision>" { "</Collision>" } else { "</colision>" };
            let at = urdf.find(to).unwrap();
            urdf = urdf[..at].to_owned() + &urdf[at..].replacen("</collision>", tag, 1);
        }
        let error = load(&urdf, ROBOT).unwrap_err();
        assert!(error.contains(part) && error.contains("stilts.urdf:"), "{to}: {error}");
    }
}

#[test]
fn files_of_other_kinds_are_called_by_their_names() {
    for (text, part) in [
        (
            changed("<robot name", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name")
                .replace("<link name=\"imu\"/>", "<link name=\"imu\"/><xacro:leg/>"),
            "is a xacro file",
        ),
        (
            changed("<link name=\"imu\"/>", "<link name=\"imu\"/><xacro:include filename=\"a\"/>"),
            "is a xacro file",
        ),
        (changed("radius=\"0.1\"", "radius=\"${r}\""), "expand the xacro file"),
        (changed("package://stilts", "$(find stilts)"), "expand the xacro file"),
        ("<sdf version=\"1.7\"/>".into(), "is an SDF file"),
        ("<mujoco/>".into(), "is an MJCF file"),
        ("<html/>".into(), "not a URDF"),
    ] {
        let error = load(&text, ROBOT).unwrap_err();
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn inertias_that_rounding_spoils_do_not_count() {
    let foot = "ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"";
    let zero = "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"";
    let rod = foot.replace("izz=\"0.01\"", "izz=\"0.000\"");
    assert!(load(&changed(foot, &rod), ROBOT).is_ok());
    let light = changed(foot, zero).replacen("<mass value=\"2\"/>", "<mass value=\"1e-9\"/>", 1);
    assert!(load(&light, ROBOT).is_ok());
    // iCub's files have such zeros.
    let nearly_zero = zero.replace("ixx=\"0\"", "ixx=\"-5.4e-20\"");
    for zero in [zero, &nearly_zero] {
        assert!(load(&changed(foot, zero), ROBOT).unwrap_err().contains("is zero"));
        let inertias = format!("{ROBOT}\n[inertias]\nleft_foot = [0.02, 0.02, 0.01]\n");
        let robot = load(&changed(foot, zero), &inertias).unwrap();
        assert_eq!(robot.links[1].inertia.to_cols_array()[0], 0.02);
    }
    let negative = foot.replace("ixx=\"0.02\"", "ixx=\"-1e-3\"");
    assert!(load(&changed(foot, &negative), ROBOT).unwrap_err().contains("positive definite"));
}

/// Darwin OP's file states all nine.
#[test]
fn moments_below_the_diagonal_repeat_those_above() {
    let foot = "ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"";
    let all = format!("{foot} iyx=\"0\" izx=\"0.0\" izy=\"0\"");
    assert!(load(&changed(foot, &all), ROBOT).is_ok());
    for other in ["izy=\"0.001\"", "izy=\"none\""] {
        let error = load(&changed(foot, &all.replace("izy=\"0\"", other)), ROBOT).unwrap_err();
        assert!(error.contains("izy of its <inertia> differs from iyz"), "{error}");
    }
}

#[test]
fn inertias_that_no_body_has_are_named_and_taken() {
    let foot = "ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"";
    let named = |foot: &str, to: &str, robot: &str| {
        let folder = Folder::new();
        let robot = load_in(&folder, &URDF.replace(foot, to), robot).unwrap();
        impossible_inertias(&robot).unwrap()
    };
    let with_izz = |izz: &str| foot.replace("izz=\"0.01\"", &format!("izz=\"{izz}\""));
    // A flat body has the sum of two moments as the third.
    assert!(named(foot, &with_izz("0.04"), ROBOT).is_empty());
    assert!(named(foot, &with_izz("0.04002"), ROBOT).is_empty());
    let both = [("left_foot".to_owned(), 7), ("right_foot".to_owned(), 11)];
    assert_eq!(named(foot, &with_izz("0.041"), ROBOT), both);
    // About axes that are turned by 45 degrees the same moments show in the products.
    let turned = "ixx=\"0.02\" ixy=\"0.015\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.025\"";
    assert_eq!(named(foot, turned, ROBOT), both);
    let stated = format!("{ROBOT}\n[inertias]\nleft_foot = [0.02, 0.02, 0.01]\n");
    assert_eq!(named(foot, &with_izz("0.041"), &stated), both[1..]);
}

/// Frames that say nothing, each fixed to the one before it, then a link that weighs.
fn frames(count: usize) -> String {
    let mut text = String::new();
    for at in 0..count {
        let parent = if at == 0 { "pelvis".to_owned() } else { format!("frame{}", at - 1) };
        text += &format!(
            "<link name=\"frame{at}\"/><joint name=\"mount{at}\" type=\"fixed\"><origin xyz=\"0.001 0 0\"/>\
             <parent link=\"{parent}\"/><child link=\"frame{at}\"/></joint>"
        );
    }
    text + &format!(
        "<link name=\"arm\"><inertial><mass value=\"1\"/>\
         <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\
         <joint name=\"shoulder\" type=\"revolute\"><origin xyz=\"0 0 1\"/><parent link=\"frame{}\"/>\
         <child link=\"arm\"/><limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"5\"/></joint></robot>",
        count - 1
    )
}

#[test]
fn many_fixed_frames_become_one_link() {
    let few = load(&changed("</robot>", &frames(10)), ROBOT).unwrap();
    let many = load(&changed("</robot>", &frames(400)), ROBOT).unwrap();
    assert_eq!((few.links.len(), many.links.len()), (15, 4));
    let arm = many.links.iter().position(|link| link.name == "arm").unwrap();
    let attachment = many.links[arm].parent.as_ref().unwrap();
    assert_eq!(many.links[attachment.parent].name, "pelvis");
    assert!((attachment.parent_from_joint.translation - DVec3::new(0.4, 0.0, 1.0)).length() < 1e-9);
    assert_eq!(many.joints[2].child, arm);
    assert_eq!(many.mass(), 15.0);
}

#[test]
fn a_foot_of_several_fixed_links_is_one() {
    let plates = |at: &str| {
        changed(
            "<collision><origin xyz=\"0 0 -0.98\"/><geometry><box size=\"0.2 0.1 0.04\"/></geometry></collision>",
            "",
        )
        .replacen("</robot>", &[("toe", "0.05"), ("heel", "-0.05")].map(|(name, x)| format!(
            "<link name=\"{name}\"><inertial><mass value=\"0.5\"/>\
             <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>\
             <collision><geometry><box size=\"0.1 0.1 0.04\"/></geometry></collision></link>\
             <joint name=\"{name}_mount\" type=\"fixed\"><origin xyz=\"{x} 0 {at}\"/><parent link=\"left_foot\"/><child link=\"{name}\"/></joint>"
        )).concat().add("</robot>"), 1)
    };
    let robot = load(&plates("-0.98"), ROBOT).unwrap();
    let foot = &robot.links[robot.feet[0].link];
    assert_eq!((foot.name.as_str(), foot.shapes.len()), ("left_foot", 2));
    let plain = load(URDF, ROBOT).unwrap();
    assert_eq!(foot.mass, 1.0 + plain.links[plain.feet[0].link].mass);
    assert_eq!(robot.mass(), 1.0 + plain.mass());
    let bare =
        ["toe", "heel"].map(|name| robot.links.iter().find(|link| link.name == name).unwrap());
    assert!(bare.iter().all(|link| link.shapes.is_empty() && link.mass == 0.0));
    assert!(load(&plates("-0.9"), ROBOT).unwrap_err().contains("foot 'left'"));
}

#[test]
fn a_sole_on_a_link_fixed_to_the_foot_belongs_to_that_link() {
    let shape = "<collision><origin xyz=\"0 0 -0.98\"/><geometry><box size=\"0.2 0.1 0.04\"/></geometry></collision>";
    let with_plate = |ankle: &str| {
        let plate = format!(
            "<link name=\"plate\">{shape}</link><joint name=\"mount\" type=\"fixed\">\
             <origin xyz=\"0 0 0.1\"/><parent link=\"left_foot\"/><child link=\"plate\"/></joint></robot>"
        );
        let ankle = shape.replace("0 0 -0.98", ankle).replace("0.2 0.1", "0.05 0.05");
        let shape_of_plate = plate.replace("0 0 -0.98", "0 0 -1.08");
        changed(shape, &ankle).replacen("</robot>", &shape_of_plate, 1)
    };
    let robot = load(&with_plate("0 0 -0.9"), ROBOT).unwrap();
    let foot = &robot.feet[0];
    assert_eq!(robot.links[foot.link].name, "plate");
    assert!((foot.link_from_sole.translation.z + 1.1).abs() < 1e-9, "{foot:?}");
    // A link that reaches near the ground is a part of the foot.
    let robot = load(&with_plate("0 0 -0.97"), ROBOT).unwrap();
    assert_eq!(robot.links[robot.feet[0].link].name, "left_foot");
}

trait Add {
    fn add(self, text: &str) -> String;
}

impl Add for String {
    fn add(self, text: &str) -> String {
        self + text
    }
}

#[test]
fn a_root_that_points_backward_is_turned_by_a_line() {
    // The whole robot turned round: feet and sole frames point along the pelvis's -x.
    let turned = ROBOT.replace(
        "sole_xyz = [0, 0, -1.0]",
        "sole_xyz = [0, 0, -1.0]\nsole_rpy = [0, 0, 3.14159265]",
    );
    let error = load(URDF, &turned).unwrap_err();
    assert!(error.lines().count() == 2 && error.contains("root_rpy = [0, 0, 3.14159]"), "{error}");
    let robot = load(URDF, &format!("root_rpy = [0, 0, 3.14159265]\n{turned}")).unwrap();
    let plain = load(URDF, ROBOT).unwrap();
    assert_eq!(robot.links.len(), plain.links.len() + 1);
    assert_eq!(robot.links[robot.joints[0].child].name, "left_foot");
    assert!((robot.root_from_urdf_root().rotation * DVec3::X + DVec3::X).length() < 1e-6);
    assert_eq!(plain.root_from_urdf_root(), surefoot_shared_types::Pose::IDENTITY);
    let one = ROBOT.replacen(
        "sole_xyz = [0, 0, -1.0]",
        "sole_xyz = [0, 0, -1.0]\nsole_rpy = [0, 0, 3.14159265]",
        1,
    );
    assert!(load(URDF, &one).unwrap_err().contains("turn the sole"));
}

#[test]
fn meshes_that_are_too_large_for_the_robot_are_asked_about() {
    let scaled = |scale: &str| {
        let urdf = changed(
            "<geometry><sphere radius=\"0.1\"/>",
            &format!("<geometry><mesh filename=\"meshes/foot.obj\" scale=\"{scale}\"/>"),
        );
        load(&urdf, ROBOT)
    };
    assert!(scaled("1 1 1").is_ok());
    let ten = scaled("10 10 10").unwrap_err();
    assert!(ten.contains("stilts.urdf:5: link 'pelvis'") && ten.contains("ten times"), "{ten}");
    let thousand = scaled("1000 1000 1000").unwrap_err();
    assert!(thousand.contains("millimetres?") && thousand.contains("0.001"), "{thousand}");
}

#[test]
fn a_mesh_file_without_a_body_is_no_shape() {
    let folder = Folder::new();
    folder.write("meshes/stub.STL", &[b' '; 80]);
    folder.write("stilts.urdf", changed("<link name=\"imu\"/>", "<link name=\"imu\"><collision><geometry><mesh filename=\"meshes/stub.STL\"/></geometry></collision></link>").as_bytes());
    let robot = load_robot(&folder.path("robot.toml")).unwrap();
    assert!(robot.links[3].shapes.is_empty());
}

/// A workspace of packages, of which `legs` holds the robot.
fn workspace(mesh: &str, files: &[&str]) -> Result<RobotModel, String> {
    workspace_of(mesh, files, "")
}

/// The same, with further lines in the robot file.
fn workspace_of(mesh: &str, files: &[&str], lines: &str) -> Result<RobotModel, String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    };
    write(
        "legs/urdf/stilts.urdf",
        URDF.replace("package://stilts/meshes/foot.obj", mesh).as_bytes(),
    );
    write("legs/urdf/robot.toml", format!("{ROBOT}\n{lines}").as_bytes());
    files.iter().for_each(|file| match file.strip_suffix("package.xml") {
        Some(of) => write(
            file,
            format!("<package><name>{}_msgs</name></package>", of.trim_end_matches('/')).as_bytes(),
        ),
        None => write(file, FOOT_OBJ.as_bytes()),
    });
    load_robot(&folder.path().join("legs/urdf/robot.toml")).map_err(|error| error.to_string())
}

#[test]
fn a_package_is_the_right_one_or_none() {
    for (mesh, files) in [
        ("package://legs/meshes/foot.obj", &["legs/meshes/foot.obj"][..]),
        ("package://head/meshes/foot.obj", &["head/meshes/foot.obj"]),
        ("model://head/meshes/foot.obj", &["head/meshes/foot.obj"]),
        ("package://head_msgs/meshes/foot.obj", &["head/meshes/foot.obj", "head/package.xml"]),
        ("package://my%20head/meshes/foot.obj", &["my head/meshes/foot.obj"]),
        ("package://head\\meshes\\foot.obj", &["head/meshes/foot.obj"]),
        ("../meshes/foot.obj", &["legs/meshes/foot.obj"]),
        ("meshes/foot.obj", &["legs/meshes/foot.obj"]),
    ] {
        workspace(mesh, files).unwrap_or_else(|error| panic!("{mesh}: {error}"));
    }
    for (mesh, files, part) in [
        ("package://head/meshes/foot.obj", &["legs/meshes/foot.obj"][..], "no folder 'head'"),
        ("package://head/meshes/foot.obj", &["legs/meshes/foot.obj", "head/foot.obj"], "head"),
        (
            "package://legs/meshes/foot.obj",
            &["legs/meshes/foot.obj", "legs/package.xml"],
            "legs has a package.xml that says 'legs_msgs'; if it is meant, state its folder",
        ),
        ("package://legs/meshes/foot.obj", &["legs/foot.obj"], "not found below"),
        ("http://example.org/foot.obj", &[], "not on this machine"),
        ("/nowhere/foot.obj", &["legs/nowhere/foot.obj"], "not found"),
    ] {
        let error = workspace(mesh, files).map(|_| ()).unwrap_err();
        assert!(error.contains(part) && error.contains("link 'right_foot'"), "{mesh}: {error}");
    }
}

#[test]
fn the_robot_file_says_where_a_package_is() {
    let mesh = "package://legs/meshes/foot.obj";
    let files = ["legs/meshes/foot.obj", "legs/package.xml", "meshes/foot.obj"];
    let read = |folder| workspace_of(mesh, &files, &format!("[packages]\nlegs = \"{folder}\""));
    let model = read("..").unwrap();
    assert!(model.mesh_paths.iter().any(|path| path.ends_with("legs/meshes/foot.obj")));
    assert!(Path::new(&model.additions.packages["legs"]).is_absolute());
    let error = read("../nowhere").map(|_| ()).unwrap_err();
    assert!(error.contains("[packages] 'legs'") && error.contains("no folder"), "{error}");
}

#[test]
fn a_missing_package_is_reported_once() {
    let of = |name: &str| {
        format!(
            "<collision><geometry><mesh filename=\"package://head/{name}\"/></geometry></collision>"
        )
    };
    let meshes: Vec<String> =
        ["a.obj", "b.obj", "c.obj", "d.obj"].iter().map(|name| of(name)).collect();
    let link = format!("<link name=\"imu\">{}</link>", meshes.join("\n"));
    let urdf = changed("<link name=\"imu\"/>", &link);
    let error = load(&urdf, ROBOT).map(|_| ()).unwrap_err();
    let of_head: Vec<&str> = error.lines().filter(|line| line.contains("head")).collect();
    let [error] = of_head[..] else { panic!("{error}") };
    for part in ["package 'head' is not found", "--package head=DIR", "(the same in lines"] {
        assert!(error.contains(part), "{error}");
    }
}
