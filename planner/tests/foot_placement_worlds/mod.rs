//! The features of the thesis's section 4.2 as small worlds.

#![allow(clippy::unwrap_used, reason = "a test ends where its world does not compile")]
#![allow(dead_code, missing_docs, reason = "each test binary uses its own part")]

use glam::{DVec2, DVec3};
use surefoot_planner::foot_placement::sole_support::{NoSupport, Support};
use surefoot_planner::foot_placement::{
    FootPlacementConfig, PlacementQuery, SampleLimits, Scratch, SoleShape, SupportedSole, Surfaces,
    propose,
};
use surefoot_shared_types::base::spatial::{rotation_about, rotation_from_rpy};
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

pub const MU: f64 = 0.6;
pub const SOLE_AREA: f64 = 0.22 * 0.14;

/// The reference sole: its frame under the ankle, 0.13 ahead of it and 0.09 behind.
pub fn sole() -> Vec<DVec2> {
    vec![
        DVec2::new(-0.09, -0.07),
        DVec2::new(0.13, -0.07),
        DVec2::new(0.13, 0.07),
        DVec2::new(-0.09, 0.07),
    ]
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z))
}

pub fn turned(x: f64, y: f64, z: f64, yaw: f64) -> Pose {
    Pose::from_parts(DVec3::new(x, y, z), rotation_about(DVec3::Z, yaw))
}

pub fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half_extents: 0.5 * DVec3::new(x, y, z) }
}

/// A box of this size with its top's centre at a point.
pub fn block(size: [f64; 3], top: [f64; 3]) -> (Shape, Pose) {
    (cuboid(size[0], size[1], size[2]), at(top[0], top[1], top[2] - 0.5 * size[2]))
}

pub fn floor() -> (Shape, Pose) {
    block([10.0, 10.0, 0.5], [0.0, 0.0, 0.0])
}

pub fn world(shapes: Vec<(Shape, Pose)>) -> World {
    let named = |(i, (shape, world_from_shape)): (usize, (Shape, Pose))| WorldShape {
        name: format!("s{i}"),
        world_from_shape,
        shape,
    };
    World {
        mu: MU,
        shapes: shapes.into_iter().enumerate().map(named).collect(),
        digest: Default::default(),
    }
}

pub fn surfaces(shapes: Vec<(Shape, Pose)>) -> Surfaces {
    Surfaces::new(&world(shapes), FootPlacementConfig::default()).unwrap()
}

pub fn support(surfaces: &Surfaces, pose: &Pose) -> Result<Support, NoSupport> {
    surfaces.support(&mut Scratch::new(surfaces.config()), &sole(), pose)
}

/// Two I-beams along y, tops at z = 0.2, their middle at x = 0, on a floor.
pub fn ibeams() -> Vec<(Shape, Pose)> {
    let mut shapes = vec![floor()];
    for x in [-0.075, 0.075] {
        shapes.push(block([0.05, 2.0, 0.015], [x, 0.0, 0.2]));
        shapes.push(block([0.015, 2.0, 0.17], [x, 0.0, 0.185]));
        shapes.push(block([0.05, 2.0, 0.015], [x, 0.0, 0.015]));
    }
    shapes
}

/// Round bars along y at z = 0 (their tops), 0.16 apart.
pub fn round_bars(count: usize) -> Vec<(Shape, Pose)> {
    let lying = rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let bar = |i: usize| {
        let centre = DVec3::new(0.16 * i as f64, 0.0, -0.02);
        (Shape::Cylinder { radius: 0.02, half_length: 0.6 }, Pose::from_parts(centre, lying))
    };
    (0..count).map(bar).collect()
}

/// Two bars 0.03 wide along y whose outer span along x is this share of the sole's length, tops at
/// z = 0.
pub fn square_bars(span_share: f64) -> Vec<(Shape, Pose)> {
    let middle = 0.5 * (span_share * 0.22 - 0.03);
    vec![
        block([0.03, 1.0, 0.03], [-middle, 0.0, 0.0]),
        block([0.03, 1.0, 0.03], [middle, 0.0, 0.0]),
    ]
}

pub fn stones() -> Vec<(Shape, Pose)> {
    let places = [(0.0, 0.12), (0.36, -0.1), (0.7, 0.13), (1.05, -0.14), (1.4, 0.09)];
    places.iter().map(|&(x, y)| block([0.28, 0.20, 0.3], [x, y, 0.0])).collect()
}

/// Solid stairs up along x: rise 0.22, tread 0.20, the first riser at x = 0.
pub fn stairs() -> Vec<(Shape, Pose)> {
    let mut shapes = vec![floor()];
    for i in 1..=6 {
        let height = 0.22 * f64::from(i);
        shapes.push(block([0.2, 1.2, height], [0.2 * f64::from(i) - 0.1, 0.0, height]));
    }
    shapes.push(block([1.5, 1.2, 1.32], [1.95, 0.0, 1.32]));
    shapes
}

/// A slope of this angle up along x through the origin.
pub fn ramp(angle: f64) -> Vec<(Shape, Pose)> {
    let rotation = rotation_about(DVec3::Y, -angle);
    vec![(cuboid(4.0, 2.0, 0.2), Pose::from_parts(rotation * DVec3::new(0.0, 0.0, -0.1), rotation))]
}

/// Six slabs of a spiral.
pub fn spiral() -> Vec<(Shape, Pose)> {
    let slab = |i: u32| {
        let angle = 0.55 * f64::from(i);
        let (sin, cos) = libm::sincos(angle);
        let height = 1.32 / 7.0 * f64::from(i + 1);
        (cuboid(0.5, 0.26, 0.05), turned(0.7 * cos, 0.7 * sin, height - 0.025, angle))
    };
    (0..6).map(slab).collect()
}

/// A pipe of radius 0.08 across the x axis, its top at (`x`, 0, `height`).
pub fn pipe(x: f64, height: f64) -> (Shape, Pose) {
    let across = rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    (
        Shape::Cylinder { radius: 0.08, half_length: 0.8 },
        Pose::from_parts(DVec3::new(x, 0.0, height - 0.08), across),
    )
}

/// A square `size` wide at z = 0 around the origin, of `n` by `n` squares of two triangles, open
/// below.
pub fn mesh(size: f64, n: u32, height: impl Fn(f64, f64) -> f64) -> (Shape, Pose) {
    let coordinate = |i: u32| size * (f64::from(i) / f64::from(n) - 0.5);
    let vertex = |i: u32, j: u32| {
        DVec3::new(coordinate(i), coordinate(j), height(coordinate(i), coordinate(j)))
    };
    let vertices =
        (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| vertex(i, j)).collect();
    let index = |i: u32, j: u32| i * (n + 1) + j;
    let square = |(i, j): (u32, u32)| {
        let corners = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    };
    let triangles = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).flat_map(square).collect();
    let source = None;
    (Shape::Mesh { vertices, triangles, source }, Pose::IDENTITY)
}

/// Rolling rubble of `2 n n` triangles, 8 m wide, with steps.
pub fn rubble(n: u32) -> (Shape, Pose) {
    mesh(8.0, n, |x, y| {
        0.05 * libm::sin(3.0 * x) * libm::cos(2.0 * y)
            + 0.03 * libm::floor(libm::sin(7.0 * x + 5.0 * y) + 0.5)
    })
}

pub fn free(_: &Pose) -> bool {
    true
}

pub fn query<'a>(sole_polygon: &'a [DVec2], ideal: Pose) -> PlacementQuery<'a> {
    PlacementQuery {
        sole: SoleShape::flat(sole_polygon),
        ideal,
        reach_xy: 0.3,
        reach_z: [-0.3, 0.3],
        yaw_spread: std::f64::consts::PI,
        seed: 1,
        object: 0,
        attempt: 0,
        limits: SampleLimits::default(),
        is_free: &free,
    }
}

/// The first `count` placements of a query.
pub fn first(surfaces: &Surfaces, query: &PlacementQuery, count: usize) -> Vec<SupportedSole> {
    let mut placements = Vec::new();
    propose(surfaces, &mut Scratch::new(surfaces.config()), query, &mut |placement| {
        placements.push(placement);
        placements.len() < count
    });
    placements
}
