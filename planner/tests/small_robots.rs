//! A robot of a third of Hubo's size: lengths that suit a robot of a man's size do not suit it.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, hubo, run};
use surefoot_planner::Outcome;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::geometry::shape::Shape;
use surefoot_shared_types::robot::model::{JointKind, RobotModel};

/// Size relative to Hubo: the legs reach 0.23 m.
const SCALE: f64 = 0.35;

fn scaled_shape(shape: &mut Shape, scale: f64) {
    match shape {
        Shape::Box { half_extents } => *half_extents *= scale,
        Shape::Sphere { radius } => *radius *= scale,
        Shape::Cylinder { radius, half_length } | Shape::Capsule { radius, half_length } => {
            *radius *= scale;
            *half_length *= scale;
        }
        Shape::ConvexHull { points: vertices, .. } | Shape::Mesh { vertices, .. } => {
            vertices.iter_mut().for_each(|vertex| *vertex *= scale);
        }
    }
}

/// Hubo with all lengths scaled, of the same density; efforts carry the same multiple of its
/// weight.
fn scaled_hubo(scale: f64) -> RobotModel {
    let mut model = hubo();
    for link in &mut model.links {
        link.mass *= scale.powi(3);
        link.com *= scale;
        link.inertia *= scale.powi(5);
        if let Some(attachment) = &mut link.parent {
            attachment.parent_from_joint.translation *= scale;
        }
        for shape in &mut link.shapes {
            shape.link_from_shape.translation *= scale;
            scaled_shape(&mut shape.shape, scale);
        }
    }
    for joint in &mut model.joints {
        assert_eq!(joint.kind, JointKind::Revolute);
        joint.effort *= scale.powi(4);
    }
    for foot in &mut model.feet {
        foot.link_from_sole.translation *= scale;
        foot.polygon.iter_mut().for_each(|corner| *corner *= scale);
    }
    model.digest = Digest::of(&[b"scaled", &scale.to_le_bytes()]);
    model
}

#[test]
fn a_small_robot_walks_over_a_floor_within_a_small_work_limit() {
    let mut case = Case { model: scaled_hubo(SCALE), ..Case::shipped("flat_walk") }
        .configured(|planner| planner.work_max = 30_000);
    case.scenario.start.stance_width *= SCALE;
    case.scenario.goal.stance_width *= SCALE;
    case.scenario.goal.position.x = case.scenario.start.position.x + 3.0;
    assert_eq!(run(&mut case.planner(2), 10_000), Outcome::Found);
}
