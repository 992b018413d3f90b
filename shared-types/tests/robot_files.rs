//! Robot files, URDFs and meshes that load as they say.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

mod common;

use common::{FOOT_OBJ, Folder, ROBOT, URDF, load};
use glam::{DVec2, DVec3};
use surefoot_shared_types::Shape;
use surefoot_shared_types::robot::model::JointKind;

#[test]
fn a_good_robot_loads_as_written() {
    let folder = Folder::new();
    let robot = load(&folder.path("")).unwrap();
    assert_eq!(
        robot.links.iter().map(|link| link.name.as_str()).collect::<Vec<_>>(),
        ["pelvis", "left_foot", "right_foot", "imu"]
    );
    assert_eq!(
        robot.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(),
        ["left_hip", "right_hip"]
    );
    assert_eq!(robot.joints[0].axis, DVec3::Y);
    assert_eq!(robot.joints[0].kind, JointKind::Revolute);
    assert_eq!(robot.joints[0].effort, 70.0);
    assert_eq!(robot.standing_q, [0.3, 0.2]);
    assert_eq!(
        robot.feet.iter().map(|foot| foot.name.as_str()).collect::<Vec<_>>(),
        ["left", "right"]
    );
    let corners = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]].map(DVec2::from_array);
    assert_eq!(robot.feet[0].polygon, corners);
    assert_eq!(robot.mass(), 14.0);
    assert!(matches!(
        &robot.links[2].shapes[0].shape,
        Shape::ConvexHull { points, .. } if points.len() == 8
    ));
}

#[test]
fn exact_meshes_stay_meshes() {
    let folder = Folder::new();
    folder.write("robot.toml", format!("exact_meshes = [\"right_foot\"]\n{ROBOT}").as_bytes());
    let robot = load(&folder.path("")).unwrap();
    let Shape::Mesh { triangles, .. } = &robot.links[2].shapes[0].shape else { panic!() };
    assert_eq!(triangles.len(), 12);
}

#[test]
fn a_locked_joint_is_folded_into_its_pose() {
    let folder = Folder::new();
    folder.write("robot.toml", format!("{ROBOT}\n[locked]\nright_hip = 0.5\n").as_bytes());
    let robot = load(&folder.path("")).unwrap();
    assert_eq!(robot.joints.len(), 1);
    let attachment = robot.links[2].parent.as_ref().unwrap();
    assert_eq!(attachment.joint, None);
    let down = attachment.parent_from_joint.rotation * -DVec3::Z;
    assert!((down - DVec3::new(-libm::sin(0.5), 0.0, -libm::cos(0.5))).length() < 1e-12);
}

#[test]
fn an_unlocked_robot_has_its_joint_back() {
    let folder = Folder::new();
    let free = load(&folder.path("")).unwrap();
    folder.write("robot.toml", format!("{ROBOT}\n[locked]\nright_hip = 0.5\n").as_bytes());
    let robot = load(&folder.path("")).unwrap();
    assert_eq!((robot.locked_joints.len(), robot.locked_joints[0].position), (1, 0.5));
    let unlocked = robot.unlocked();
    assert_eq!((&unlocked.joints, &unlocked.links), (&free.joints, &free.links));
    assert_eq!(unlocked.standing_q[1], 0.5);
}

#[test]
fn a_frame_fixed_to_a_foot_stands_for_it() {
    let folder = Folder::new();
    let plain = load(&folder.path("")).unwrap();
    let sole = "<link name=\"imu\"/><link name=\"right_sole\"/>\
                <joint name=\"right_sole_mount\" type=\"fixed\"><origin xyz=\"0 0 -1\"/><parent link=\"right_foot\"/><child link=\"right_sole\"/></joint>";
    folder.write("stilts.urdf", URDF.replacen("<link name=\"imu\"/>", sole, 1).as_bytes());
    let file = ROBOT.replacen(
        "link = \"right_foot\"\nsole_xyz = [0, 0, -1.0]",
        "link = \"right_sole\"\nsole_xyz = [0, 0, 0]",
        1,
    );
    folder.write("robot.toml", file.as_bytes());
    assert_eq!(load(&folder.path("")).unwrap().feet, plain.feet);
    folder.write(
        "stilts.urdf",
        URDF.replacen("<link name=\"imu\"/>", sole, 1)
            .replacen("right_foot\"/><child", "imu\"/><child", 1)
            .as_bytes(),
    );
    let error = load(&folder.path("")).unwrap_err().to_string();
    assert!(error.contains("foot 'right'") && error.contains("'pelvis'"), "{error}");
    let bare = URDF.replacen(
        "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>",
        "",
        1,
    );
    assert_ne!(bare, URDF);
    folder.write("stilts.urdf", bare.as_bytes());
    folder.write(
        "robot.toml",
        ROBOT.replacen("link = \"right_foot\"", "link = \"imu\"", 1).as_bytes(),
    );
    let error = load(&folder.path("")).unwrap_err().to_string();
    assert!(
        error.contains("foot 'right'") && error.contains("'imu' has no collision shape"),
        "{error}"
    );
}

/// [`URDF`] with the left hip half as far as the right one, and a tenth on.
fn with_mimic() -> String {
    URDF.replacen(
        "<axis xyz=\"0 2 0\"/>",
        "<axis xyz=\"0 1 0\"/><mimic joint=\"right_hip\" multiplier=\"0.5\" offset=\"0.1\"/>",
        1,
    )
}

#[test]
fn a_joint_that_mimics_a_locked_one_is_held_with_it() {
    let folder = Folder::new();
    folder.write("stilts.urdf", with_mimic().as_bytes());
    let file = |position: f64| {
        ROBOT.replace("[standing]\nleft_hip = 0.3", &format!("[locked]\nright_hip = {position}"))
    };
    folder.write("robot.toml", file(0.5).as_bytes());
    let robot = load(&folder.path("")).unwrap();
    let locked: Vec<_> = robot
        .locked_joints
        .iter()
        .map(|locked| (locked.joint.name.as_str(), locked.position))
        .collect();
    assert_eq!((robot.joints.len(), locked), (0, vec![("left_hip", 0.35), ("right_hip", 0.5)]));
    let spoilings = [
        (ROBOT.to_owned(), "lock that one"),
        (format!("{}\n[standing]\nleft_hip = 0.3\n", file(0.5)), "mimics one that is"),
        (file(1.5).replace("1.5", "1.5\nleft_hip = 2"), "outside its limits"),
    ];
    for (robot, complaint) in spoilings {
        folder.write("robot.toml", robot.as_bytes());
        let error = load(&folder.path("")).unwrap_err().to_string();
        assert!(error.contains("left_hip") && error.contains(complaint), "{error}");
    }
    folder.write("stilts.urdf", with_mimic().replace("offset=\"0.1\"", "offset=\"9\"").as_bytes());
    folder.write("robot.toml", file(0.5).as_bytes());
    let error = load(&folder.path("")).unwrap_err().to_string();
    assert!(error.contains("mimics 'right_hip' to 9.25, outside its limits -1..1.5"), "{error}");
}

#[test]
fn a_joint_is_held_by_the_one_that_its_own_mimics() {
    let folder = Folder::new();
    let middle = "<link name=\"imu\"/><link name=\"cam\"><inertial><mass value=\"0.1\"/><inertia \
                  ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" izz=\"1e-4\"/></inertial></link>\
                  <joint name=\"pan\" type=\"revolute\"><parent link=\"imu\"/><child link=\"cam\"/>\
                  <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>\
                  <mimic joint=\"right_hip\" multiplier=\"0.5\" offset=\"0.2\"/></joint>";
    let urdf = URDF.replacen("<link name=\"imu\"/>", middle, 1).replacen(
        "<axis xyz=\"0 2 0\"/>",
        "<axis xyz=\"0 1 0\"/><mimic joint=\"pan\" multiplier=\"3\" offset=\"0.1\"/>",
        1,
    );
    folder.write("stilts.urdf", urdf.as_bytes());
    let file = ROBOT.replace("[standing]\nleft_hip = 0.3", "[locked]\nright_hip = 0.4");
    folder.write("robot.toml", file.as_bytes());
    let robot = load(&folder.path("")).unwrap();
    let locked = robot.locked_joints.iter();
    let positions: Vec<_> =
        locked.map(|locked| (locked.joint.name.as_str(), locked.position)).collect();
    let held = |name: &str| positions.iter().find(|(other, _)| *other == name).unwrap().1;
    assert!((held("pan") - 0.4).abs() < 1e-12, "{positions:?}");
    assert!((held("left_hip") - 1.3).abs() < 1e-12, "{positions:?}");
}

/// A hand between two walls, of which only the hull meets it, two joints from them.
const HAND: &str = r#"<link name="imu"/>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><origin xyz="0 0 1.1"/><geometry><sphere radius="0.03"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="pelvis"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="5"/>
  </joint>
  <joint name="wrist" type="revolute">
    <parent link="arm"/><child link="hand"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="5"/>
  </joint>"#;
const WALLS_OBJ: &str = "v -0.1 -0.1 1\nv -0.1 0.1 1\nv -0.1 0.1 1.2\nv -0.1 -0.1 1.2\nv 0.1 -0.1 1\nv 0.1 0.1 1\nv 0.1 0.1 1.2\n\
v 0.1 -0.1 1.2\nf 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n";

#[test]
fn a_hull_that_hides_collisions_gives_way_whichever_joints_are_locked() {
    let folder = Folder::new();
    let walls = "<sphere radius=\"0.1\"/></geometry></collision>";
    assert!(URDF.contains(walls));
    let with_walls = format!(
        "{walls}<collision><geometry><mesh filename=\"meshes/walls.obj\"/></geometry></collision>"
    );
    folder.write(
        "stilts.urdf",
        URDF.replacen(walls, &with_walls, 1).replacen("<link name=\"imu\"/>", HAND, 1).as_bytes(),
    );
    folder.write("meshes/walls.obj", WALLS_OBJ.as_bytes());
    for locked in ["", "\n[locked]\nshoulder = 0.4\n"] {
        folder.write("robot.toml", format!("{ROBOT}{locked}").as_bytes());
        let robot = load(&folder.path("")).unwrap();
        assert!(matches!(robot.links[0].shapes[1].shape, Shape::Mesh { .. }), "locked: '{locked}'");
    }
}

#[test]
fn what_other_programs_add_to_a_urdf_is_passed_over() {
    let folder = Folder::new();
    let plain = load(&folder.path("")).unwrap();
    let extended = URDF
        .replace("<robot name", "<robot xmlns:drake=\"http://drake.mit.edu\" name")
        .replace("<link name=\"imu\"/>", "<link name=\"imu\"/><drake:joint name=\"ball\" type=\"ball\"><drake:part/></drake:joint>")
        .replace("</collision>", "</collision><visual><material/><material/></visual>")
        .replace("<link name=\"imu\"/>", "<link name=\"imu\"/><material/><sensor><link/></sensor>")
        .replace(
            "foot.obj\"/>",
            "foot.obj\"><drake:declare_convex/><!-- a note --><convex/></mesh>",
        );
    assert_eq!(extended.matches("drake").count(), 6);
    folder.write("stilts.urdf", extended.as_bytes());
    let robot = load(&folder.path("")).unwrap();
    assert_eq!(robot.links, plain.links);
    assert_eq!(robot.joints, plain.joints);
}

#[test]
fn a_sphere_of_no_radius_is_no_shape() {
    let folder = Folder::new();
    folder.write(
        "stilts.urdf",
        URDF.replace("<sphere radius=\"0.1\"/>", "<sphere radius=\"0.0\"/>").as_bytes(),
    );
    let robot = load(&folder.path("")).unwrap();
    assert!(robot.links[0].shapes.is_empty(), "{:?}", robot.links[0]);
}

#[test]
fn a_continuous_joint_gets_one_turn() {
    let folder = Folder::new();
    folder.write(
        "stilts.urdf",
        URDF.replacen("type=\"revolute\"", "type=\"continuous\"", 1).as_bytes(),
    );
    let joint = load(&folder.path("")).unwrap().joints[0].clone();
    assert_eq!((joint.lower, joint.upper), (-std::f64::consts::PI, std::f64::consts::PI));
}

#[test]
fn the_digest_covers_urdf_robot_file_and_meshes() {
    let digest = |file: &str, text: String| {
        let folder = Folder::new();
        folder.write(file, text.as_bytes());
        load(&folder.path("")).unwrap().digest
    };
    let same = digest("robot.toml", ROBOT.to_owned());
    assert_eq!(same, digest("stilts.urdf", URDF.to_owned()));
    assert_ne!(same, digest("robot.toml", format!("{ROBOT}\n")));
    assert_ne!(same, digest("stilts.urdf", format!("{URDF}\n")));
    assert_ne!(same, digest("meshes/foot.obj", format!("{FOOT_OBJ}\n")));
}
