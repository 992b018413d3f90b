//! The narrow phase compared with parry's distances, which use other algorithms, at random poses.

use glam::{DQuat, DVec3};
use parry3d_f64::query::distance;
use parry3d_f64::shape::{Ball, ConvexPolyhedron, Cuboid, Cylinder, Segment, SharedShape, TriMesh};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::geometry::narrow_phase::is_within;
use surefoot_planner::geometry::solid::Solid;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;
use surefoot_shared_types::{Pose, Shape};

const POSES: usize = 20_000;
/// Largest error of parry's distance between flat cores, m.
const TOLERANCE: f64 = 1e-7;
/// Largest excess of parry's distance for curved cores, m.
const CURVED_TOLERANCE: f64 = 1e-4;

fn vector(random: &mut Random, lower: f64, upper: f64) -> DVec3 {
    DVec3::new(
        random.uniform(lower, upper),
        random.uniform(lower, upper),
        random.uniform(lower, upper),
    )
}

fn rotation(random: &mut Random) -> DQuat {
    // One in four is a multiple of 90 degrees, with parallel edges.
    if random.below(4) == 0 {
        let quarter_turns = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X]
            .map(|axis| axis * std::f64::consts::FRAC_PI_2);
        return rotation_from_scaled_axis(quarter_turns[random.below(4)])
            * rotation_from_scaled_axis(quarter_turns[random.below(4)]);
    }
    rotation_from_scaled_axis(vector(random, -3.0, 3.0))
}

fn box_of(half_extents: DVec3) -> Shape {
    Shape::Box { half_extents }
}

fn ellipsoid_hull(count: usize, seed: u64) -> Shape {
    let mut random = Random::new(seed, Stream::Preparation, 9, 0);
    let on_ellipsoid =
        (0..count).map(|_| vector(&mut random, -1.0, 1.0).normalize() * DVec3::new(0.2, 0.3, 0.15));
    Shape::ConvexHull { points: on_ellipsoid.collect(), source: None }
}

/// A closed triangle mesh: a block with an uneven top.
fn bumpy_block() -> Shape {
    const CELLS: usize = 6;
    let mut random = Random::new(3, Stream::Preparation, 8, 0);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::<[u32; 3]>::new());
    for level in 0..2 {
        for row in 0..=CELLS {
            for column in 0..=CELLS {
                let height = if level == 1 { 0.2 + random.uniform(0.0, 0.1) } else { -0.1 };
                vertices.push(DVec3::new(
                    row as f64 * 0.1 - 0.3,
                    column as f64 * 0.1 - 0.3,
                    height,
                ));
            }
        }
    }
    let at = |level: usize, row: usize, column: usize| {
        ((level * (CELLS + 1) + row) * (CELLS + 1) + column) as u32
    };
    let mut quad = |a, b, c, d| triangles.extend([[a, b, c], [a, c, d]]);
    for i in 0..CELLS {
        for j in 0..CELLS {
            quad(at(1, i, j), at(1, i + 1, j), at(1, i + 1, j + 1), at(1, i, j + 1));
            quad(at(0, i, j), at(0, i, j + 1), at(0, i + 1, j + 1), at(0, i + 1, j));
        }
        quad(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
        quad(at(0, i, CELLS), at(1, i, CELLS), at(1, i + 1, CELLS), at(0, i + 1, CELLS));
        quad(at(0, 0, i), at(1, 0, i), at(1, 0, i + 1), at(0, 0, i + 1));
        quad(at(0, CELLS, i), at(0, CELLS, i + 1), at(1, CELLS, i + 1), at(1, CELLS, i));
    }
    Shape::Mesh { vertices, triangles, source: None }
}

/// The same shape for parry: a core, its pose (cylinders lie along y there), and the radius around
/// it.
fn of_parry(shape: &Shape) -> (SharedShape, Pose, f64) {
    let upright = Pose::from_parts(
        DVec3::ZERO,
        rotation_from_scaled_axis(DVec3::X * std::f64::consts::FRAC_PI_2),
    );
    let segment = |half: f64| SharedShape::new(Segment::new(DVec3::Z * half, DVec3::Z * -half));
    match shape {
        Shape::Box { half_extents } => {
            (SharedShape::new(Cuboid::new(*half_extents)), Pose::IDENTITY, 0.0)
        }
        Shape::Sphere { radius } => (SharedShape::new(Ball::new(*radius)), Pose::IDENTITY, 0.0),
        Shape::Cylinder { radius, half_length } => {
            (SharedShape::new(Cylinder::new(*half_length, *radius)), upright, 0.0)
        }
        Shape::Capsule { radius, half_length } => (segment(*half_length), Pose::IDENTITY, *radius),
        Shape::ConvexHull { points, .. } => (
            SharedShape::new(ConvexPolyhedron::from_convex_hull(points).expect("a solid hull")),
            Pose::IDENTITY,
            0.0,
        ),
        Shape::Mesh { vertices, triangles, .. } => (
            SharedShape::new(TriMesh::new(vertices.clone(), triangles.clone()).expect("a mesh")),
            Pose::IDENTITY,
            0.0,
        ),
    }
}

/// Compares results at margins on both sides of parry's distance.
fn assert_agrees(a: &Shape, b: &Shape, poses: usize) {
    let (solid_a, solid_b) = (Solid::new(a, "a").expect("good"), Solid::new(b, "b").expect("good"));
    let ((parry_a, core_a, radius_a), (parry_b, core_b, radius_b)) = (of_parry(a), of_parry(b));
    let is_curved = [a, b].iter().any(|shape| matches!(shape, Shape::Cylinder { .. }));
    let slack = if is_curved { CURVED_TOLERANCE } else { TOLERANCE };
    let mut random = Random::new(11, Stream::Preparation, 7, 0);
    let (mut free, mut hit) = (0, 0);
    for _ in 0..poses {
        let a_from_b = Pose::from_parts(vector(&mut random, -0.9, 0.9), rotation(&mut random));
        let of_cores = distance(&core_a, &*parry_a, &(a_from_b * core_b), &*parry_b)
            .expect("parry supports the pair")
            .distance;
        let expected = (of_cores - radius_a - radius_b).max(0.0);
        let within = |margin| is_within(&solid_a, &solid_b, &a_from_b, margin);
        let both = |margin| {
            assert_eq!(
                within(margin),
                is_within(&solid_b, &solid_a, &a_from_b.inverse(), margin),
                "not symmetric at {a_from_b:?}"
            );
            within(margin)
        };
        for margin in [expected + TOLERANCE, expected + 0.01] {
            assert!(
                both(margin),
                "{a:?}\n{b:?}\n{a_from_b:?}: distance {expected} is within {margin}"
            );
        }
        if expected > slack {
            assert!(
                !both(expected - slack),
                "{a:?}\n{b:?}\n{a_from_b:?}: distance {expected} is beyond {}",
                expected - slack
            );
            assert!(!within(0.0));
            free += 1;
        } else {
            hit += 1;
        }
    }
    assert!(free > poses / 20 && hit > poses / 100, "{free} free, {hit} hit");
}

fn convex_shapes() -> Vec<Shape> {
    vec![
        box_of(DVec3::new(0.1, 0.3, 0.2)),
        box_of(DVec3::new(0.4, 0.02, 0.3)),
        Shape::Sphere { radius: 0.25 },
        Shape::Capsule { radius: 0.1, half_length: 0.3 },
        Shape::Cylinder { radius: 0.2, half_length: 0.15 },
        ellipsoid_hull(12, 1),
        ellipsoid_hull(200, 2),
    ]
}

#[test]
fn primitives_agree_with_parry() {
    let shapes = &convex_shapes()[..4];
    for (index, a) in shapes.iter().enumerate() {
        for b in &shapes[index..] {
            assert_agrees(a, b, POSES);
        }
    }
}

#[test]
fn cylinders_and_hulls_agree_with_parry() {
    let shapes = convex_shapes();
    for (index, a) in shapes.iter().enumerate() {
        for b in &shapes[index.max(4)..] {
            assert_agrees(a, b, POSES / 2);
        }
    }
}

#[test]
fn meshes_agree_with_parry_outside_of_them() {
    let Shape::Mesh { vertices, mut triangles, source } = bumpy_block() else { unreachable!() };
    triangles.pop();
    let open = Shape::Mesh { vertices, triangles, source };
    for shape in convex_shapes() {
        assert_agrees(&open, &shape, POSES / 10);
    }
    assert_agrees(&open, &open, POSES / 40);
}

#[test]
fn a_solid_inside_a_closed_mesh_is_a_hit_and_inside_an_open_one_is_not() {
    let closed = bumpy_block();
    let small = Solid::new(&Shape::Sphere { radius: 0.01 }, "small").unwrap();
    let Shape::Mesh { vertices, triangles, source } = closed.clone() else { unreachable!() };
    let open = Shape::Mesh { vertices, triangles: triangles[1..].to_vec(), source };
    let (closed, open) =
        (Solid::new(&closed, "closed").unwrap(), Solid::new(&open, "open").unwrap());
    let mut random = Random::new(5, Stream::Preparation, 6, 0);
    for _ in 0..POSES {
        let at = DVec3::new(
            random.uniform(-0.5, 0.5),
            random.uniform(-0.5, 0.5),
            random.uniform(-0.3, 0.18),
        );
        let inside = at.abs().cmple(DVec3::new(0.28, 0.28, 1.0)).all() && at.z > -0.08;
        let outside = at.abs().cmpge(DVec3::new(0.32, 0.32, 1.0)).any() || at.z < -0.12;
        let hit = is_within(&closed, &small, &Pose::from_parts(at, DQuat::IDENTITY), 0.0);
        assert!(!inside || hit, "{at} is inside");
        assert!(!outside || !hit, "{at} is outside");
    }
    assert!(
        is_within(&closed, &small, &Pose::IDENTITY, 0.0)
            && is_within(&small, &closed, &Pose::IDENTITY, 0.0)
    );
    // At the origin a ray along an axis would pass through edges.
    assert!(!is_within(&open, &small, &Pose::IDENTITY, 0.0));
}

#[test]
fn nearly_parallel_edges_and_capsules_are_found() {
    let (box_shape, capsule) =
        (box_of(DVec3::splat(0.2)), Shape::Capsule { radius: 0.05, half_length: 0.4 });
    let solids = [&box_shape, &capsule].map(|shape| Solid::new(shape, "s").unwrap());
    let mut random = Random::new(2, Stream::Preparation, 5, 0);
    for _ in 0..POSES {
        let rotation = rotation_from_scaled_axis(
            vector(&mut random, -1.0, 1.0) * libm::pow(10.0, random.uniform(-14.0, -2.0)),
        );
        for (solid, half) in solids.iter().zip([0.2, 0.05]) {
            let apart = 2.0 * half + 0.03;
            let along_x =
                Pose::from_parts(DVec3::new(apart, 0.0, random.uniform(-0.1, 0.1)), rotation);
            let slack = 0.03 * 0.4 + 1e-9;
            assert!(is_within(solid, solid, &along_x, 0.03 + slack), "{along_x:?}");
            assert!(!is_within(solid, solid, &along_x, 0.03 - slack), "{along_x:?}");
        }
    }
}

#[test]
fn nan_is_a_hit() {
    let invalid = Pose::from_parts(DVec3::splat(f64::NAN), DQuat::IDENTITY);
    for a in convex_shapes() {
        for b in convex_shapes() {
            let (a, b) = (Solid::new(&a, "a").unwrap(), Solid::new(&b, "b").unwrap());
            assert!(is_within(&a, &b, &invalid, 0.01));
        }
    }
}

#[test]
fn a_sphere_of_no_radius_is_a_point() {
    let point = Solid::new(&Shape::Sphere { radius: 0.0 }, "contact point").unwrap();
    for shape in [box_of(DVec3::splat(0.2)), Shape::Sphere { radius: 0.2 }, bumpy_block()] {
        let solid = Solid::new(&shape, "s").unwrap();
        let side = solid.aabb().max.x;
        let beside = Pose::from_parts(DVec3::X * (side + 0.03), DQuat::IDENTITY);
        assert!(
            is_within(&solid, &point, &beside, 0.031) && !is_within(&solid, &point, &beside, 0.029),
            "{shape:?}"
        );
    }
}

#[test]
fn errors_of_degenerate_shapes_name_the_owner() {
    let flat =
        [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.3, 0.4, 0.0)];
    let source = || None;
    let bad = [
        Shape::ConvexHull { points: flat.to_vec(), source: None },
        Shape::ConvexHull { points: vec![DVec3::ZERO; 9], source: None },
        Shape::ConvexHull { points: vec![DVec3::NAN; 9], source: None },
        Shape::ConvexHull {
            points: (0..9).map(|i| DVec3::X * f64::from(i)).collect(),
            source: None,
        },
        Shape::ConvexHull { points: Vec::new(), source: None },
        box_of(DVec3::new(0.1, 0.0, 0.1)),
        box_of(DVec3::new(0.1, f64::INFINITY, 0.1)),
        Shape::Sphere { radius: f64::NAN },
        Shape::Sphere { radius: -0.1 },
        Shape::Capsule { radius: 0.1, half_length: -1.0 },
        Shape::Mesh { vertices: vec![DVec3::ZERO], triangles: vec![[0, 0, 1]], source: source() },
        Shape::Mesh { vertices: vec![DVec3::ZERO], triangles: Vec::new(), source: source() },
    ];
    for shape in bad {
        let error = Solid::new(&shape, "link 'left_shin', shape 2").unwrap_err().to_string();
        assert!(error.starts_with("link 'left_shin', shape 2: "), "{error}");
    }
}
