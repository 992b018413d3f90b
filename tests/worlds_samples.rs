//! The worlds in which foot placement is tried alone.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use glam::{DVec3, dvec3};
use sole_support::{
    SOLE_SIZE, bounds, contacts, half_extents, heading, named, shape, sole_at, support_area, world,
};
use surefoot_shared_types::Shape;

const EPSILON: f64 = 2e-6;
/// Metres that rounding to six decimals may cost.
const ROUNDING: f64 = 1e-5;

#[test]
fn parallel_bars_span_their_share_of_the_sole() {
    for percent in (60..=130).step_by(5) {
        let world = world(&format!("parallel_bars_{percent}"));
        assert_eq!(world.shapes.len(), 2);
        let [one, other] = ["bar_1", "bar_2"].map(|name| bounds(shape(&world, name)));
        for (low, high) in [one, other] {
            assert!((high.x - low.x - 0.03).abs() < EPSILON && high.z.abs() < EPSILON);
        }
        let span = other.1.x - one.0.x;
        assert!(
            (span - SOLE_SIZE.x * f64::from(percent) / 100.0).abs() < ROUNDING,
            "{percent}: {span}"
        );
        assert!((other.1.x + one.0.x).abs() < ROUNDING, "they lie about the origin");
    }
}

#[test]
fn a_sole_no_longer_rests_on_both_bars_at_the_widest_spans_only() {
    let rests_on_both = |percent: i32| {
        let world = world(&format!("parallel_bars_{percent}"));
        let poses = (-60..=60).flat_map(|shift| {
            (-20..=20).map(move |turn| (2e-3 * f64::from(shift), 0.05 * f64::from(turn)))
        });
        let mut poses = poses.map(|(shift, turn)| sole_at(dvec3(shift, 0.0, 0.0), turn));
        poses.any(|pose| {
            let touched = contacts(&world, &pose);
            touched.iter().any(|p| p.x < 0.0)
                && touched.iter().any(|p| p.x > 0.0)
                && support_area(&world, &pose) > 0.008
        })
    };
    for percent in (60..=130).step_by(5) {
        assert!(rests_on_both(percent), "{percent}");
    }
}

#[test]
fn ramps_lie_on_either_side_of_friction() {
    for (name, share) in [("features/ramp_0_9", 0.9), ("features/ramp_1_1", 1.1)] {
        let world = world(name);
        let ramp = shape(&world, "ramp");
        let normal = ramp.world_from_shape.rotation * DVec3::Z;
        assert!((libm::acos(normal.z) - share * libm::atan(world.mu)).abs() < EPSILON, "{name}");
        let over_origin =
            normal.dot(DVec3::ZERO - ramp.world_from_shape * dvec3(0.0, 0.0, half_extents(ramp).z));
        assert!(over_origin.abs() < ROUNDING, "{name} passes {over_origin} from the origin");
    }
}

#[test]
fn v_groove_has_two_faces_that_hold_and_meet() {
    let world = world("features/v_groove");
    for (name, side) in [("right", 1.0), ("left", -1.0)] {
        let face = shape(&world, name);
        let half = half_extents(face);
        let normal = face.world_from_shape.rotation * DVec3::Z;
        assert!(libm::acos(normal.z) < libm::atan(world.mu) && normal.x * side < -0.1);
        let valley = face.world_from_shape * dvec3(-side * half.x, 0.0, half.z);
        assert!(valley.length() < ROUNDING, "{name} ends at {valley}");
    }
}

#[test]
fn m_groove_is_steeper_than_friction_and_wider_than_a_sole() {
    let world = world("m_groove");
    assert_eq!(world.shapes.len(), 2);
    for (half, side) in world.shapes.iter().zip([1.0, -1.0]) {
        let Shape::ConvexHull { points, .. } = &half.shape else {
            panic!("'{}' is not convex", half.name)
        };
        let top = points.iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        assert!((top.x - side * 0.30).abs() < EPSILON, "half the opening");
        let slope = libm::atan2(top.z, top.x.abs());
        assert!((slope - 1.25 * libm::atan(world.mu)).abs() < 1e-5, "a quarter too steep");
        assert!(
            (top.x * top.x + top.z * top.z).sqrt() > SOLE_SIZE.x,
            "a whole sole lies on one face"
        );
        let lowest =
            points.iter().filter(|p| p.x.abs() < EPSILON).map(|p| p.z).fold(f64::MIN, f64::max);
        assert!(lowest.abs() < EPSILON, "the valley");
        assert!(points.iter().all(|p| p.x * side >= 0.0), "the halves only touch");
    }
}

#[test]
fn ring_is_eight_blocks_none_of_which_carries_a_sole_alone() {
    let world = world("features/ring");
    let blocks = named(&world, "block_");
    assert_eq!(blocks.len(), 8);
    for (index, block) in blocks.iter().enumerate() {
        assert!((block.world_from_shape.translation.truncate().length() - 0.1).abs() < EPSILON);
        assert!(
            (heading(block).rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::FRAC_PI_4 * index as f64)
                .abs()
                < EPSILON
        );
        assert!(4.0 * half_extents(block).x * half_extents(block).y < 0.008);
    }
    assert!(
        support_area(&world, &sole_at(dvec3(-0.02, 0.0, 0.0), 0.0)) > 0.008,
        "together they do"
    );
}

#[test]
fn the_other_features_have_their_shapes() {
    assert!(matches!(world("features/cylinder").shapes[0].shape, Shape::Cylinder { .. }));
    assert_eq!(world("features/sphere_cap").shapes[0].shape, Shape::Sphere { radius: 1.5 });
    let edge = bounds(&world("features/box_edge").shapes[0]).1;
    assert!(edge.x.abs() < EPSILON && edge.z.abs() < EPSILON, "the edge passes through the origin");
    let flange = bounds(shape(&world("features/ibeam"), "top_flange"));
    assert!((flange.1.x - flange.0.x - 0.12).abs() < EPSILON && flange.1.z.abs() < EPSILON);
    let staircase = world("features/staircase");
    let tops: Vec<f64> = named(&staircase, "step_").iter().map(|step| bounds(step).1.z).collect();
    assert!(
        tops.windows(2).all(|pair| (pair[1] - pair[0] - 0.22).abs() < EPSILON) && tops.len() == 5
    );
    let rubble = world("features/rubble_mesh");
    let Shape::Mesh { vertices, triangles, .. } = &rubble.shapes[0].shape else {
        panic!("rubble is a mesh")
    };
    assert_eq!(triangles.len(), 2 * 24 * 24);
    assert!(vertices.iter().all(|v| (-0.05..=0.0).contains(&v.z)));
}
