//! Lower bounds on the signed distance of two solids.
//!
//! The gap of two convex solids along a unit direction is the distance from the end of the first to
//! the beginning of the second; a negative gap is the translation along the direction that
//! separates them. The signed distance is the largest gap over all directions, so *any* direction
//! gives a lower bound, by two support points. parry's GJK and EPA only propose directions: if they
//! stop early or fail, the bound is small and counts as an overlap, never as free space. A mesh is
//! processed triangle by triangle.

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::query::details::{
    closest_points_support_map_support_map_with_params, contact_support_map_support_map,
};
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{SupportMap, TriMesh};
use surefoot_shared_types::Pose;

use crate::geometry::body::SolidPose;
use crate::geometry::bounds::Bounds;
use crate::geometry::solid::{Convex, Core, Solid};

/// A lower bound on the signed distance of two solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// The bound, m; negative where they may overlap.
    pub distance: f64,
    /// The unit direction, in the world, from the first solid to the second, along which the gap is
    /// this wide.
    pub direction: DVec3,
}

impl Separation {
    fn better(self, other: Self) -> Self {
        if other.distance > self.distance { other } else { self }
    }
}

/// The separation of two solids: exact up to rounding, or any bound of at least `enough` (m).
/// `hint` is a direction to try first, in the world.
pub fn separation(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
) -> Separation {
    separation_until(a, b, hint, enough, f64::NEG_INFINITY)
}

/// As [`separation`], but of meshes the first triangle that is nearer than `stop` (m) ends it.
pub fn separation_until(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
    stop: f64,
) -> Separation {
    let apart = a.1.bounds.distance(&b.1.bounds);
    // Overlapping boxes do not bound the penetration depth of their contents.
    if apart > 0.0 && apart >= enough {
        return Separation { distance: apart, direction: hint };
    }
    match (a.0, b.0) {
        (Solid::Convex(first), Solid::Convex(second)) => convex_separation(
            (first, &a.1.world_from_solid),
            (second, &b.1.world_from_solid),
            hint,
            enough,
        ),
        (Solid::Mesh(mesh), other) => {
            let mesh = (&mesh.surface, &a.1.world_from_solid);
            mesh_separation(mesh, (other, b.1), hint, (enough, stop))
        }
        (other, Solid::Mesh(mesh)) => {
            let mesh = (&mesh.surface, &b.1.world_from_solid);
            let turned = mesh_separation(mesh, (other, a.1), -hint, (enough, stop));
            Separation { direction: -turned.direction, ..turned }
        }
    }
}

/// Whether a point (in the world, m) lies inside a closed mesh: whether at least two of three rays
/// from it first hit the back of a triangle.
pub fn is_inside_mesh(mesh: &TriMesh, world_from_mesh: &Pose, point: DVec3) -> bool {
    let origin = world_from_mesh.inverse() * point;
    let directions = [
        DVec3::new(0.11, 0.23, 0.97),
        DVec3::new(-0.71, 0.13, 0.69),
        DVec3::new(0.19, -0.83, -0.53),
    ];
    let leaves = |direction: DVec3| {
        let hit = mesh.cast_local_ray_and_get_normal(&Ray::new(origin, direction), f64::MAX, false);
        hit.is_some_and(|hit| face_normal(mesh, hit.subshape).dot(direction) > 0.0)
    };
    directions.into_iter().filter(|&direction| leaves(direction)).count() >= 2
}

/// The outward unit normal of a mesh's triangle.
pub fn face_normal(mesh: &TriMesh, triangle: u32) -> DVec3 {
    let corners = mesh.triangle(triangle);
    (corners.b - corners.a).cross(corners.c - corners.a).normalize_or_zero()
}

fn mesh_separation(
    mesh: (&TriMesh, &Pose),
    other: (&Solid, &SolidPose),
    hint: DVec3,
    (enough, stop): (f64, f64),
) -> Separation {
    let near = other.1.bounds.transformed(&mesh.1.inverse()).expanded(enough.max(0.0));
    let mut worst = Separation { distance: enough, direction: hint };
    for index in mesh.0.bvh().intersect_aabb(&Aabb::new(near.low, near.high)) {
        let corners = mesh.0.triangle(index);
        let triangle =
            Convex { core: Core::Triangle([corners.a, corners.b, corners.c]), radius: 0.0 };
        let found = match other.0 {
            Solid::Convex(convex) => convex_separation(
                (&triangle, mesh.1),
                (convex, &other.1.world_from_solid),
                worst.direction,
                worst.distance,
            ),
            Solid::Mesh(second) => {
                let bounds =
                    Bounds::of_points([corners.a, corners.b, corners.c]).transformed(mesh.1);
                let placed = SolidPose { world_from_solid: *mesh.1, bounds };
                let solid = Solid::Convex(triangle);
                let turned = mesh_separation(
                    (&second.surface, &other.1.world_from_solid),
                    (&solid, &placed),
                    -worst.direction,
                    (worst.distance, stop),
                );
                Separation { direction: -turned.direction, ..turned }
            }
        };
        if found.distance < worst.distance {
            worst = found;
        }
        if worst.distance < stop {
            break;
        }
    }
    worst
}

/// A convex solid and its pose in the world.
pub type PlacedConvex<'a> = (&'a Convex, &'a Pose);

/// The separation of two convex solids.
pub fn convex_separation(a: PlacedConvex, b: PlacedConvex, hint: DVec3, enough: f64) -> Separation {
    let hinted = along(a, b, hint);
    if hinted.distance >= enough {
        return hinted;
    }
    let closest = closest_direction(a, b);
    let known = closest.map_or(hinted, |direction| hinted.better(along(a, b, direction)));
    let is_apart = known.distance + a.0.radius + b.0.radius > 0.0;
    if is_apart {
        return known;
    }
    let axes = separating_axes(a, b).into_iter().chain([deepest_direction(a, b)]);
    axes.fold(known, |best, axis| best.better(along(a, b, axis)))
}

/// The gap along one direction.
fn along(a: PlacedConvex, b: PlacedConvex, direction: DVec3) -> Separation {
    let end = a.0.core.support_point(a.1, direction).dot(direction) + a.0.radius;
    let begin = b.0.core.support_point(b.1, -direction).dot(direction) - b.0.radius;
    Separation { distance: begin - end, direction }
}

/// The direction between the closest points of two solids, in the world, if GJK finds them apart.
/// On solids that touch it may name points that are not the closest ones.
fn closest_direction(a: PlacedConvex, b: PlacedConvex) -> Option<DVec3> {
    let a_from_b = a.1.inverse() * *b.1;
    let found = closest_points_support_map_support_map_with_params(
        &a_from_b,
        &a.0.core,
        &b.0.core,
        f64::MAX,
        &mut VoronoiSimplex::new(),
        None,
    );
    let GJKResult::ClosestPoints(on_first, on_second, _) = found else { return None };
    let direction = (on_second - on_first).try_normalize()?;
    (on_first.distance(on_second) > TOUCHING_MAX).then_some(a.1.rotation * direction)
}

/// The direction along which EPA finds the smallest depth of two solids, in the world.
fn deepest_direction(a: PlacedConvex, b: PlacedConvex) -> DVec3 {
    let a_from_b = a.1.inverse() * *b.1;
    let contact = contact_support_map_support_map(&a_from_b, &a.0.core, &b.0.core, TOUCHING_MAX);
    contact.map_or(DVec3::Z, |contact| (a.1.rotation * contact.normal1).normalize_or(DVec3::Z))
}

/// Below this distance (m) the direction between closest points is inaccurate.
const TOUCHING_MAX: f64 = 1e-6;

/// Both solids' face normals and the cross products of their edges, in both directions. They
/// separate boxes and triangles, and replace EPA's direction where EPA fails.
fn separating_axes(a: PlacedConvex, b: PlacedConvex) -> Vec<DVec3> {
    let edges = [a, b].map(|(convex, pose)| edges(&convex.core).map(|edge| pose.rotation * edge));
    let crosses = edges[0]
        .into_iter()
        .flat_map(|x| edges[1].into_iter().filter_map(move |y| x.cross(y).try_normalize()));
    let faces = [a, b].into_iter().flat_map(|(convex, pose)| {
        faces(&convex.core).into_iter().map(|normal| pose.rotation * normal)
    });
    faces.chain(crosses).flat_map(|axis| [axis, -axis]).collect()
}

/// Directions of a core's edges; of one without, the axes.
fn edges(core: &Core) -> [DVec3; 3] {
    match core {
        Core::Triangle([a, b, c]) => [b - a, c - b, a - c].map(DVec3::normalize_or_zero),
        Core::Box(_) | Core::Segment(_) | Core::Cylinder { .. } | Core::Hull(_) => DVec3::AXES,
    }
}

/// Normals of a core's faces, for a triangle also of its edges in its plane; of one without, the
/// axes.
fn faces(core: &Core) -> Vec<DVec3> {
    let Core::Triangle([a, b, c]) = core else { return DVec3::AXES.to_vec() };
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let beside = edges(core).map(|edge| edge.cross(normal));
    [normal, beside[0], beside[1], beside[2]].into_iter().filter_map(DVec3::try_normalize).collect()
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::base::spatial::rotation_from_rpy;

    use super::*;

    fn measure(a: &Shape, pose_a: Pose, b: &Shape, pose_b: Pose) -> f64 {
        let place = |shape: &Shape, pose: Pose| {
            let solid = Solid::new(shape).unwrap();
            let bounds = solid.local_bounds().transformed(&pose);
            (solid, SolidPose { world_from_solid: pose, bounds })
        };
        let ((first, placed), (second, other)) = (place(a, pose_a), place(b, pose_b));
        separation((&first, &placed), (&second, &other), DVec3::X, 10.0).distance
    }

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_translation(DVec3::new(x, y, z))
    }

    fn cube(half: f64) -> Shape {
        Shape::Box { half_extents: DVec3::splat(half) }
    }

    fn cube_mesh(half: f64) -> Shape {
        let corner = |i: u32| {
            DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 * half
                - half
        };
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads
            .iter()
            .flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .collect();
        let source = None;
        Shape::Mesh { vertices: (0..8).map(corner).collect(), triangles, source }
    }

    #[test]
    fn distances_and_depths_of_round_shapes_are_closed_form() {
        let ball = Shape::Sphere { radius: 0.5 };
        let capsule = Shape::Capsule { radius: 0.1, half_length: 0.4 };
        assert!((measure(&ball, at(0., 0., 0.), &ball, at(3., 4., 0.)) - 4.0).abs() < 1e-9);
        assert!((measure(&ball, at(0., 0., 0.), &cube(1.0), at(0., 0., 1.49)) + 0.01).abs() < 1e-9);
        assert!(
            (measure(&capsule, at(0., 0., 0.), &cube(1.0), at(0., 0., 1.6)) - 0.1).abs() < 1e-9
        );
        assert!(
            (measure(&capsule, at(0., 0., 0.), &capsule, at(0.15, 0., 0.)) + 0.05).abs() < 1e-9
        );
    }

    #[test]
    fn an_overlap_is_measured_for_any_sufficient_distance() {
        let solid = Solid::new(&cube(1.0)).unwrap();
        let place = |pose: Pose| SolidPose {
            world_from_solid: pose,
            bounds: solid.local_bounds().transformed(&pose),
        };
        for enough in [-0.003, 0.0, 0.1] {
            let found = separation(
                (&solid, &place(at(0., 0., 0.))),
                (&solid, &place(at(0., 0., 1.5))),
                DVec3::X,
                enough,
            );
            assert!((found.distance + 0.5).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn a_turned_cube_on_its_edge_is_measured() {
        let turned = Pose::from_parts(
            DVec3::new(0.0, 0.0, 1.0 + 2.0_f64.sqrt() - 0.003),
            rotation_from_rpy(std::f64::consts::FRAC_PI_4, 0.0, 0.3),
        );
        assert!((measure(&cube(1.0), at(0., 0., 0.), &cube(1.0), turned) + 0.003).abs() < 1e-8);
    }

    #[test]
    fn a_mesh_has_the_distance_of_its_solid_and_an_inside() {
        for z in [1.2, 1.05, 0.999] {
            let solid = measure(&cube(0.5), at(0., 0., 0.), &cube(0.3), at(0.1, 0., z - 0.2));
            let mesh = measure(&cube_mesh(0.5), at(0., 0., 0.), &cube(0.3), at(0.1, 0., z - 0.2));
            assert!((solid - mesh).abs() < 1e-8, "{solid} {mesh}");
        }
        let Solid::Mesh(mesh) = Solid::new(&cube_mesh(0.5)).unwrap() else { unreachable!() };
        assert!(is_inside_mesh(&mesh.surface, &at(1., 0., 0.), DVec3::new(0.7, 0.1, 0.2)));
        assert!(!is_inside_mesh(&mesh.surface, &at(1., 0., 0.), DVec3::new(0.3, 0.1, 0.2)));
    }

    #[test]
    fn random_boxes_agree_with_the_separating_axis_theorem() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..500 {
            let mut pose = || {
                Pose::from_parts(
                    DVec3::new(random(), random(), random()),
                    rotation_from_rpy(6.0 * random(), 3.0 * random(), 6.0 * random()),
                )
            };
            let (a, b) = (pose(), pose());
            let (small, flat) =
                (cube(0.2), Shape::Box { half_extents: DVec3::new(0.3, 0.2, 0.02) });
            let found = measure(&small, a, &flat, b);
            let cores = [Core::Box(DVec3::splat(0.2)), Core::Box(DVec3::new(0.3, 0.2, 0.02))]
                .map(|core| Convex { core, radius: 0.0 });
            let axes = separating_axes((&cores[0], &a), (&cores[1], &b))
                .into_iter()
                .map(|axis| along((&cores[0], &a), (&cores[1], &b), axis).distance);
            let by_axes = axes.fold(f64::NEG_INFINITY, f64::max);
            assert!(found >= by_axes - 1e-9, "a direction proposed by GJK is worse than an axis");
            if by_axes < 0.0 {
                assert!((found - by_axes).abs() < 1e-7, "{found} {by_axes}");
            }
        }
    }

    #[test]
    fn a_flat_sole_on_a_slanted_triangle_is_not_deep_in_it() {
        let corners =
            [DVec3::new(-0.3, -0.2, -0.05), DVec3::new(0.4, -0.1, 0.02), DVec3::new(0.1, 0.5, 0.0)];
        let source = None;
        let ramp = Shape::Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]], source };
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let sole = Shape::Box { half_extents: DVec3::new(0.1, 0.05, 0.02) };
        for turn in [0.0, 0.4, 1.1, 2.3] {
            for depth in [0.001, 0.004] {
                let rotation = glam::DQuat::from_rotation_arc(DVec3::Z, normal)
                    * rotation_from_rpy(0.0, 0.0, turn);
                let pose = Pose::from_parts(middle + normal * (0.02 - depth), rotation);
                let found = measure(&sole, pose, &ramp, at(0., 0., 0.));
                assert!(
                    (found + depth).abs() < 1e-9,
                    "turned by {turn}: {found} in place of {depth}"
                );
            }
        }
    }

    #[test]
    fn a_foot_on_a_facet_is_not_deep_in_it_where_gjk_calls_them_apart() {
        let foot = [
            [-0.07950624823570251, -0.03650624305009842, -0.044999998062849045],
            [-0.08464685827493668, 0.037950001657009125, -0.03999999910593033],
            [0.13370470702648163, -0.037522170692682266, -0.044999998062849045],
            [0.16894225776195526, -0.021090630441904068, -0.044999998062849045],
            [0.1708318144083023, 0.000980237266048789, -0.017925940454006195],
            [0.13265320658683777, 0.037879109382629395, -0.044999998062849045],
        ];
        let foot = foot.map(DVec3::from).to_vec();
        let foot = Solid::new(&Shape::ConvexHull { points: foot, source: None }).unwrap();
        let Solid::Convex(foot) = &foot else { unreachable!() };
        let rotation = glam::DQuat::from_xyzw(
            -0.011678453415415985,
            0.07810996770212783,
            0.059828110855654856,
            0.9950794158371685,
        );
        let place = DVec3::new(0.7476530805513233, -0.06925167731607526, 0.018419896446795793);
        let facet = [
            [0.6000000238418579, -0.10000000149011612, -0.007499999832361937],
            [0.699999988079071, -0.10000000149011612, -0.018699999898672104],
            [0.699999988079071, 0.0, -0.02199999988079071],
        ];
        let facet = Convex { core: Core::Triangle(facet.map(DVec3::from)), radius: 0.0 };
        let pose = Pose::from_parts(place, rotation);
        let (a, b) = ((&facet, &Pose::IDENTITY), (foot, &pose));
        let called = along(a, b, closest_direction(a, b).unwrap());
        assert!(called.distance < -0.1, "{called:?}");
        let found = convex_separation(a, b, DVec3::Z, 0.0);
        assert!(found.distance.abs() < 2e-3, "{found:?}");
        let turned = convex_separation(b, a, -DVec3::Z, 0.0);
        assert!((found.distance - turned.distance).abs() < 1e-9, "{turned:?}");
    }

    #[test]
    fn a_turned_mesh_has_outward_normals_and_an_inside() {
        let Solid::Mesh(mesh) = Solid::new(&cube_mesh(0.5)).unwrap() else { unreachable!() };
        for index in 0..12 {
            let triangle = mesh.surface.triangle(index);
            let middle = (triangle.a + triangle.b + triangle.c) / 3.0;
            let normal = face_normal(&mesh.surface, index);
            assert!((normal.length() - 1.0).abs() < 1e-12);
            // The middle of a face's half lies 0.5 from the centre along the normal.
            assert!((normal.dot(middle) - 0.5).abs() < 1e-12);
        }
        let pose = Pose::from_parts(DVec3::new(1.0, 2.0, -1.0), rotation_from_rpy(0.4, -0.9, 2.0));
        for (at, is_inside) in [
            ([0.0; 3], true),
            ([0.49, -0.49, 0.49], true),
            ([0.51, 0.0, 0.0], false),
            ([0.0, -0.51, 0.2], false),
            ([0.4, 0.4, 0.6], false),
        ] {
            assert_eq!(is_inside_mesh(&mesh.surface, &pose, pose * DVec3::from(at)), is_inside);
        }
    }
}
