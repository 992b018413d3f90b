//! Soles that robot files declare: what lies on the foot carries, and nothing of the foot is below.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;

use check_robot::*;
use glam::DVec3;
use surefoot_controller_sim::{Checker, CheckerError};
use surefoot_shared_types::config::CheckerConfig;
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
    let named = |model: RobotModel| -> Vec<String> {
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
    let [line] = &named(arched)[..] else { panic!("one sole is hollow") };
    let percent: f64 = line.split(' ').next().unwrap().parse().unwrap();
    assert!((28.0..=33.0).contains(&percent) && line.contains("the left sole"), "{line}");
}
