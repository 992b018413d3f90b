//! The reference robot is the one that the worlds were made for.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

use std::path::Path;

use glam::{DMat3, DVec2, DVec3};
use surefoot_shared_types::Shape;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::{Joint, RobotModel};

const EPSILON: f64 = 1e-9;
const LEG: [&str; 6] = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"];

fn hubo() -> RobotModel {
    load_robot(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo/robot.toml"))
        .unwrap()
}

fn joint_index(robot: &RobotModel, name: &str) -> usize {
    robot
        .joints
        .iter()
        .position(|joint| joint.name == name)
        .unwrap_or_else(|| panic!("no joint '{name}'"))
}

fn joint<'a>(robot: &'a RobotModel, name: &str) -> &'a Joint {
    &robot.joints[joint_index(robot, name)]
}

/// Where each link's frame lies in the root's when all joints are at zero; no frame is turned
/// there.
fn origins_at_zero(robot: &RobotModel) -> Vec<DVec3> {
    let mut origins = vec![DVec3::ZERO];
    for link in &robot.links[1..] {
        let attachment = link.parent.as_ref().unwrap();
        assert!(
            (attachment.parent_from_joint.rotation.w.abs() - 1.0).abs() < 1e-12,
            "'{}' is turned",
            link.name
        );
        origins.push(origins[attachment.parent] + attachment.parent_from_joint.translation);
    }
    origins
}

fn origin_of_joint(robot: &RobotModel, name: &str) -> DVec3 {
    origins_at_zero(robot)[joint(robot, name).child]
}

/// Half the height of a shape that is not turned.
fn half_height(shape: &Shape) -> f64 {
    match shape {
        Shape::Box { half_extents } => half_extents.z,
        Shape::Sphere { radius } => *radius,
        Shape::Cylinder { half_length, .. } => *half_length,
        Shape::Capsule { radius, half_length } => radius + half_length,
        Shape::ConvexHull { .. } | Shape::Mesh { .. } => {
            panic!("the reference robot is made of primitives")
        }
    }
}

#[test]
fn weight_joints_and_height_are_those_of_the_reference() {
    let robot = hubo();
    assert_eq!(robot.joints.len(), 27);
    assert!((57.0..=59.0).contains(&robot.mass()), "{} kg", robot.mass());
    let origins = origins_at_zero(&robot);
    let spans = robot.links.iter().zip(&origins).flat_map(|(link, origin)| {
        link.shapes.iter().map(move |shape| {
            (origin.z + shape.link_from_shape.translation.z, half_height(&shape.shape))
        })
    });
    let (low, high) = spans.fold((f64::MAX, f64::MIN), |(low, high), (z, half)| {
        (low.min(z - half), high.max(z + half))
    });
    assert!((1.5..=1.6).contains(&(high - low)), "{} m tall", high - low);
}

#[test]
fn legs_have_the_reference_lengths_and_meeting_axes() {
    let robot = hubo();
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let origins = LEG.map(|part| origin_of_joint(&robot, &format!("{side}_{part}")));
        let axes = LEG.map(|part| joint(&robot, &format!("{side}_{part}")).axis);
        assert_eq!(axes, [DVec3::Z, DVec3::X, DVec3::Y, DVec3::Y, DVec3::Y, DVec3::X]);
        assert_eq!([origins[1], origins[2]], [origins[0]; 2], "hip axes meet");
        assert!(
            (origins[0] - DVec3::new(0.0, sign * 0.0885, origins[0].z)).length() < EPSILON,
            "hip place"
        );
        assert!((origins[2] - origins[3] - DVec3::new(0.0, 0.0, 0.33)).length() < EPSILON, "thigh");
        assert!((origins[3] - origins[4] - DVec3::new(0.0, 0.0, 0.33)).length() < EPSILON, "shank");
        assert_eq!(origins[4], origins[5], "ankle axes meet");
    }
}

#[test]
fn leg_limits_are_those_of_the_reference() {
    let robot = hubo();
    let expected = [
        (-1.92, 1.92, 150.0),
        (-0.52, 0.52, 150.0),
        (-1.87, 1.61, 220.0),
        (-0.07, 2.61, 220.0),
        (-1.7, 1.7, 150.0),
        (-1.57, 1.57, 150.0),
    ];
    for side in ["left", "right"] {
        for (part, limits) in LEG.iter().zip(expected) {
            let joint = joint(&robot, &format!("{side}_{part}"));
            assert_eq!((joint.lower, joint.upper, joint.effort), limits, "{}", joint.name);
        }
    }
    assert_eq!(joint(&robot, "waist_yaw").effort, 100.0);
    let arms = robot.joints.iter().filter(|joint| {
        ["shoulder", "elbow", "wrist"].iter().any(|part| joint.name.contains(part))
    });
    assert_eq!(arms.filter(|joint| joint.effort == 60.0).count(), 14);
}

#[test]
fn soles_are_the_bottom_faces_of_the_feet() {
    let robot = hubo();
    assert_eq!(
        robot.feet.iter().map(|foot| foot.name.as_str()).collect::<Vec<_>>(),
        ["left", "right"]
    );
    for foot in &robot.feet {
        let sole = foot.link_from_sole.translation;
        assert!((sole - DVec3::new(0.0, 0.0, -0.12)).length() < EPSILON, "below the ankle axes");
        let corners = foot.polygon.iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), point| {
            (low.min(*point), high.max(*point))
        });
        assert_eq!(corners, (DVec2::new(-0.09, -0.07), DVec2::new(0.13, 0.07)));
        let [shape] = robot.links[foot.link].shapes.as_slice() else { panic!("a foot is one box") };
        let Shape::Box { half_extents } = shape.shape else { panic!("a foot is a box") };
        let centre = shape.link_from_shape.translation;
        assert!((centre.z - half_extents.z - sole.z).abs() < EPSILON);
        assert!(((centre - half_extents).truncate() - corners.0).length() < EPSILON);
        assert!(((centre + half_extents).truncate() - corners.1).length() < EPSILON);
    }
}

#[test]
fn shins_have_the_reference_radius() {
    let robot = hubo();
    for shin in robot.links.iter().filter(|link| link.name.ends_with("_shin")) {
        assert!(
            matches!(shin.shapes[0].shape, Shape::Capsule { radius: 0.065, .. }),
            "{}",
            shin.name
        );
    }
}

#[test]
fn standing_keeps_the_soles_level_and_the_knees_bent() {
    let robot = hubo();
    let at = |name: String| robot.standing_q[joint_index(&robot, &name)];
    for side in ["left", "right"] {
        let pitches = ["hip_pitch", "knee", "ankle_pitch"].map(|part| at(format!("{side}_{part}")));
        assert!(pitches.iter().sum::<f64>().abs() < EPSILON);
        assert!((0.3..=0.7).contains(&pitches[1]));
        assert_eq!(
            ["hip_yaw", "hip_roll", "ankle_roll"].map(|part| at(format!("{side}_{part}"))),
            [0.0; 3]
        );
    }
}

#[test]
fn inertias_are_those_of_solid_bodies() {
    for link in hubo().links {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = link.inertia;
        let symmetric = x.y == y.x && x.z == z.x && y.z == z.y;
        let principal_minors = [x.x, x.x * y.y - x.y * y.x, link.inertia.determinant()];
        assert!(
            link.mass > 0.0 && symmetric && principal_minors.iter().all(|minor| *minor > 0.0),
            "{}",
            link.name
        );
        let largest = x.x.max(y.y).max(z.z);
        assert!(2.0 * largest <= x.x + y.y + z.z, "{} breaks the triangle inequality", link.name);
    }
}

#[test]
fn left_and_right_mirror_each_other() {
    let robot = hubo();
    let origins = origins_at_zero(&robot);
    let mirrored = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
    for left in robot.joints.iter().filter(|joint| joint.name.starts_with("left_")) {
        let right = joint(&robot, &left.name.replace("left_", "right_"));
        let limits = if left.axis == DVec3::Y {
            (left.lower, left.upper)
        } else {
            (-left.upper, -left.lower)
        };
        assert_eq!((right.lower, right.upper), limits, "{}", right.name);
        assert_eq!(
            (right.axis, right.effort, right.velocity),
            (left.axis, left.effort, left.velocity)
        );
        assert!((origins[right.child] - mirrored(origins[left.child])).length() < EPSILON);
        let (left_link, right_link) = (&robot.links[left.child], &robot.links[right.child]);
        assert_eq!(right_link.mass, left_link.mass);
        assert!((right_link.com - mirrored(left_link.com)).length() < EPSILON);
    }
}

#[test]
fn pinocchio_reference_is_about_this_robot() {
    let robot = hubo();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/pinocchio_hubo.json");
    let reference: serde_json::Value =
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let names = |key: &str| -> Vec<String> {
        let mut names: Vec<_> = reference[key]
            .as_array()
            .unwrap()
            .iter()
            .map(|name| name.as_str().unwrap().to_owned())
            .collect();
        names.sort();
        names
    };
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    assert_eq!(
        names("joint_names"),
        sorted(robot.joints.iter().map(|joint| joint.name.clone()).collect())
    );
    assert_eq!(
        names("link_names"),
        sorted(robot.links.iter().map(|link| link.name.clone()).collect())
    );
    assert!((reference["mass"].as_f64().unwrap() - robot.mass()).abs() < EPSILON);
    assert!(reference["configurations"].as_array().unwrap().len() >= 50);
}
