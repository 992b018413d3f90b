//! How deep a stance foot may be in the world where it is longer than its sole.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod check_robot;
mod checked_motion;

use check_robot::*;
use checked_motion::{check_motion, refused};
use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::{Check, Margins};
use surefoot_shared_types::robot::model::{LinkShape, RobotModel};
use surefoot_shared_types::world::world::World;

/// The robot with feet 3 cm longer than their soles.
fn with_toes(below: f64) -> RobotModel {
    let mut robot = robot();
    let link_from_shape = at(0.115, 0.0, -0.88 - below);
    for leg in [1, 2] {
        robot.links[leg]
            .shapes
            .push(LinkShape { link_from_shape, shape: box_of(0.015, 0.05, 0.02) });
    }
    robot
}

fn stand(robot: RobotModel, world: World) -> Result<Margins, surefoot_controller_sim::Violation> {
    check_motion(robot, world, &both_feet(), &[waypoint(0.0, 0.0, 0.0), waypoint(1.0, 0.0, 0.0)])
}

#[test]
fn toes_below_the_sole_may_be_as_deep_in_the_ground_as_they_reach_below_it() {
    for below in [0.0, 1e-3, 2.9e-3] {
        stand(with_toes(below), world(vec![])).unwrap();
    }
    let found = stand(with_toes(3.1e-3), world(vec![]));
    refused(found, Check::Collision, "by 3.10 mm, limit 3.00 mm");
}

#[test]
fn the_edge_of_a_foot_may_be_deep_in_steep_ground_and_not_in_gentle_one() {
    // The lower edge of the left toe is 1 mm deep in a block inclined by this angle.
    let on = |incline: f64| {
        let up = DVec3::new(-libm::sin(incline), 0.0, libm::cos(incline));
        let middle = DVec3::new(0.13, 0.1, 0.0) - (0.05 - 1e-3) * up;
        let block = Pose::from_parts(middle, DQuat::from_rotation_y(-incline));
        stand(with_toes(0.0), world(vec![("block", block, box_of(0.05, 0.04, 0.05))]))
    };
    on(1.05).unwrap();
    refused(on(0.52), Check::Collision, "by 1.00 mm, limit 0.30 mm");
}
