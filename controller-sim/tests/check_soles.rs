//! Soles that robot files declare: what lies on the foot carries, and nothing of the foot is below.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use glam::DVec3;
use surefoot_controller_sim::{Checker, CheckerError, HollowSole};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::robot::model::{LinkShape, RobotModel};
use surefoot_shared_types::{Pose, Shape};

/// The robot with another shape on its left foot, at a place in the frame of the sole.
fn with_foot_part(place: DVec3, half: DVec3) -> RobotModel {
    let mut model = robot();
    let link_from_shape = at(0., 0., -0.9) * Pose::from_translation(place);
    let shape = Shape::Box { half_extents: half };
    model.links[1].shapes.push(LinkShape { link_from_shape, shape });
    model
}

#[test]
fn a_foot_may_not_reach_below_its_sole_between_the_corners() {
    let stud = |below: f64| {
        let model = with_foot_part(DVec3::new(0.02, 0.01, 0.005 - below), DVec3::splat(0.005));
        Checker::new(model, world(vec![]), CheckerConfig::default()).map(drop)
    };
    assert_eq!(stud(0.0029), Ok(()));
    let error = stud(0.0042).unwrap_err();
    assert_eq!(error, CheckerError::FootBelowSole { foot: "left".into(), millimetres: 5 });
    assert!(error.to_string().contains("reaches 5 mm below"), "{error}");
}

#[test]
fn the_part_of_a_sole_that_lies_on_the_foot_is_named() {
    let named = |model: RobotModel| -> Vec<HollowSole> {
        let checker = Checker::new(model, world(vec![]), CheckerConfig::default()).unwrap();
        checker.hollow_soles().collect()
    };
    assert!(named(robot()).is_empty());
    // Two pads of 3 cm at the ends of a foot of 20 cm.
    let mut arched = robot();
    arched.links[1].shapes.truncate(1);
    for x in [-0.085, 0.085] {
        let link_from_shape = at(x, 0., -0.88);
        let shape = Shape::Box { half_extents: DVec3::new(0.015, 0.05, 0.02) };
        arched.links[1].shapes.push(LinkShape { link_from_shape, shape });
    }
    let [sole] = &named(arched)[..] else { panic!("one sole is hollow") };
    assert!((28.0..=33.0).contains(&sole.percent_on_foot), "{sole:?}");
    assert!((99.0..=100.0).contains(&sole.percent_carrying), "{sole:?}");
    let line = sole.to_string();
    assert!(line.contains("the left sole lie on the foot, 99 % between these parts"), "{line}");
}

#[test]
fn a_support_does_not_depend_on_the_height_of_the_ground() {
    // On a hill it shrinks with the height of the centre of mass over the sole.
    let width = |height: f64| {
        let hill = ("hill", at(0., 0.1, height - 8.0), Shape::Sphere { radius: 8.0 });
        let mut checker =
            Checker::new(robot(), world(vec![hill]), CheckerConfig::default()).unwrap();
        let (mut on_hill, mut waypoint) = (contact(0), waypoint(0.0, 0.0, 0.0));
        on_hill.position[2] += height;
        waypoint.root_position[2] += height;
        let supports = checker.sole_supports(&[on_hill], &[waypoint]);
        supports.corners().map(|corner| corner.x).fold(0.0, f64::max)
    };
    let widths = [1.0, 3.0].map(width);
    assert!(widths[0] > 0.05 && widths[0] < 0.099, "{widths:?}");
    assert!((widths[0] - widths[1]).abs() < 1e-6, "{widths:?}");
}

/// Whether the robot may stand with its left sole on level ground and a stone of this width and
/// height (m) at a place on it.
fn on_stone(place: [f64; 2], width: f64, height: f64) -> Result<(), String> {
    let half = 0.5 * (height + 0.02);
    let [x, y] = place;
    let stone = ("stone", at(x, 0.1 + y, half - 0.02), box_of(0.5 * width, 0.5 * width, half));
    let standing = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    let found = check_motion(robot(), world(vec![stone]), &both_feet(), &standing);
    found.map(drop).map_err(|violation| violation.detail)
}

#[test]
fn a_foot_does_not_stand_on_a_stone_between_the_rays_under_its_sole() {
    let mut random = randoms(3);
    let mut unseen = 0;
    for _ in 0..40 {
        let place = [random(-0.08, 0.08), random(-0.04, 0.04)];
        let refusal = on_stone(place, 2e-3, 2.5e-3).expect_err("the foot rocks on it");
        unseen += usize::from(refusal.contains("left_leg overlaps stone by 2.50 mm, limit 0.3"));
        on_stone(place, 2e-3, 1e-4).unwrap();
    }
    assert!(unseen > 10, "{unseen}");
}

#[test]
fn a_foot_does_not_stand_on_a_stone_beside_its_sole() {
    // The foot reaches 2 cm farther ahead than its sole.
    let standing = [waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)];
    let on_plate = |height: f64| {
        let model = with_foot_part(DVec3::new(0.11, 0.0, 0.02), DVec3::new(0.01, 0.05, 0.02));
        let plate = ("plate", at(0.113, 0.1, height - 0.05), box_of(0.005, 0.05, 0.05));
        check_motion(model, world(vec![plate]), &both_feet(), &standing)
    };
    on_plate(2e-4).unwrap();
    refused(on_plate(2.5e-3), Check::Collision, "left_leg overlaps plate by 2.50 mm, limit 0.3");
}
