//! The depth of solids of which surfaces cross.
//!
//! The triangles of a mesh have no thickness, so the depth of a triangle in another solid does not
//! measure the overlap of the solids. Here the depth is that of the deepest point of one surface
//! inside the other solid: its distance to the surface of that solid. This distance changes no
//! faster than the point moves, so no point of a part of a triangle is deeper than the part's
//! middle by more than the part's radius. Only parts that may hold the deepest point are divided
//! (branch and bound).

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::query::PointQuery;
use surefoot_shared_types::Pose;

use crate::base::comparison::{is_at_most, is_below, largest};
use crate::geometry::body::SolidPose;
use crate::geometry::bounds::Bounds;
use crate::geometry::mesh_solid::MeshSolid;
use crate::geometry::separation::{Separation, is_inside_mesh, separation, separation_until};
use crate::geometry::solid::{Convex, Core, Solid};

/// A part of a triangle is divided until all of it is this near its middle, m. The depth may
/// exceed the measured one by less than that.
const PART_RADIUS_MAX: f64 = 1.5e-3;
/// Triangles that overlap less than this count as touching, m.
const CROSSING_DEPTH_MIN: f64 = 1e-4;

/// As [`separation`], but where one solid is a mesh, and the surfaces cross or one solid lies
/// inside the mesh, the depth is at least that of the deepest point of a surface inside the other
/// solid.
pub fn solid_separation(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
) -> Separation {
    let found = separation(a, b, hint, enough);
    if !is_mesh(a.0) && !is_mesh(b.0) {
        return found;
    }
    let overlaps =
        found.distance < -CROSSING_DEPTH_MIN || has_middle_of(a, b) || has_middle_of(b, a);
    if !overlaps {
        return found;
    }
    Separation { distance: found.distance.min(-deepest_point(a, b, 0.0)), ..found }
}

/// As [`solid_separation`], for bodies that do not stand on each other: where triangles of two
/// meshes cross, the depth is that of the boxes around them.
pub fn body_separation(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
) -> Separation {
    if !is_mesh(a.0) || !is_mesh(b.0) {
        return solid_separation(a, b, hint, enough);
    }
    let found = separation_until(a, b, hint, enough, 0.0);
    if found.distance >= 0.0 {
        return found;
    }
    Separation { distance: -depth_of_boxes(a, b), ..found }
}

/// The depth that [`body_separation`] measures, m, or `known` if that is greater. Parts of the
/// solids that are no deeper than `known` are not measured.
pub fn body_depth(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose), known: f64) -> f64 {
    if a.1.bounds.distance(&b.1.bounds) > 0.0 {
        return known;
    }
    let hint = (b.1.bounds.centre() - a.1.bounds.centre()).normalize_or(DVec3::X);
    if is_mesh(a.0) && is_mesh(b.0) {
        let depth = depth_of_boxes(a, b);
        let crosses = || is_below(separation_until(a, b, hint, 0.0, 0.0).distance, 0.0);
        return if is_below(known, depth) && crosses() { depth } else { known };
    }
    let of_triangles = known.max(-separation(a, b, hint, -known).distance);
    if is_mesh(a.0) || is_mesh(b.0) { deepest_point(a, b, of_triangles) } else { of_triangles }
}

/// The depth of the boxes around two solids, along the axes of either, m: a translation that
/// separates them. It does not depend on how the two are turned together.
fn depth_of_boxes(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose)) -> f64 {
    let along_axes_of = |(own, placed): (&Solid, &SolidPose),
                         (other, there): (&Solid, &SolidPose)| {
        let own_from_other = placed.world_from_solid.inverse() * there.world_from_solid;
        own.local_bounds().penetration(&other.local_bounds().transformed(&own_from_other))
    };
    along_axes_of(a, b).min(along_axes_of(b, a))
}

fn is_mesh(solid: &Solid) -> bool {
    matches!(solid, Solid::Mesh(_))
}

/// Whether the middle of a solid lies inside a closed mesh whose box holds the box of the solid.
fn has_middle_of((mesh, placed): (&Solid, &SolidPose), (_, other): (&Solid, &SolidPose)) -> bool {
    let Solid::Mesh(mesh) = mesh else { return false };
    mesh.is_closed
        && placed.bounds.holds(&other.bounds)
        && is_inside_mesh(&mesh.surface, &placed.world_from_solid, other.bounds.centre())
}

/// The depth of the deepest point of either surface inside the other solid, m; `known` where no
/// point is deeper.
fn deepest_point(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose), known: f64) -> f64 {
    deepest_of_first(b, a, deepest_of_first(a, b, known))
}

/// The depth of the deepest point of the surface of `a` inside `b`, m; `known` where no point is
/// deeper.
fn deepest_of_first(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose), known: f64) -> f64 {
    if matches!(b.0, Solid::Mesh(mesh) if !mesh.is_closed) {
        return known;
    }
    let near = b.1.bounds.transformed(&a.1.world_from_solid.inverse());
    let b_from_a = b.1.world_from_solid.inverse() * a.1.world_from_solid;
    let mut deepest = known;
    for triangle in triangles_near(a.0, &near) {
        let part: Vec<DVec3> =
            clipped(&triangle, &near).into_iter().map(|at| b_from_a * at).collect();
        let Some((&first, rest)) = part.split_first() else { continue };
        for pair in rest.windows(2) {
            deepest = deepest_of_part([first, pair[0], pair[1]], b.0, deepest);
        }
    }
    deepest
}

/// The depth of the deepest point of a triangle (in the frame of the solid) inside a solid, m;
/// `known` where no point is deeper.
fn deepest_of_part([a, b, c]: [DVec3; 3], solid: &Solid, known: f64) -> f64 {
    let middle = (a + b + c) / 3.0;
    let radius = largest([a, b, c].map(|corner| corner.distance(middle)));
    let depth = signed_depth(solid, middle, known - radius);
    if is_at_most(depth, known - radius) {
        return known;
    }
    let deepest = known.max(depth);
    if !is_below(PART_RADIUS_MAX, radius) {
        let at_corner = |deepest: f64, at| deepest.max(signed_depth(solid, at, deepest));
        return [a, b, c].into_iter().fold(deepest, at_corner);
    }
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    let parts = [[ab, bc, ca], [a, ab, ca], [ab, b, bc], [ca, bc, c]];
    parts.into_iter().fold(deepest, |deepest, part| deepest_of_part(part, solid, deepest))
}

/// The distance of a point (in the frame of the solid, m) inside a solid to its surface; negative
/// outside. Where it is at most `needed`, any number up to that.
fn signed_depth(solid: &Solid, point: DVec3, needed: f64) -> f64 {
    match solid {
        Solid::Convex(convex) => depth_in_convex(convex, point),
        Solid::Mesh(mesh) => depth_in_mesh(mesh, point, needed),
    }
}

/// The distance of a point (in the frame of the solid, m) inside a convex solid to its surface;
/// negative outside, and there no further from 0 than the distance.
fn depth_in_convex(convex: &Convex, point: DVec3) -> f64 {
    match &convex.core {
        Core::Box(half) => (*half - point.abs()).min_element() + convex.radius,
        Core::Segment(half_length) => {
            let nearest = DVec3::new(0.0, 0.0, point.z.clamp(-half_length, *half_length));
            convex.radius - point.distance(nearest)
        }
        Core::Cylinder { radius, half_length } => {
            (radius - point.truncate().length()).min(half_length - point.z.abs())
        }
        Core::Hull(hull) => hull.depth(point) + convex.radius,
        // A triangle has no inside.
        Core::Triangle(_) => f64::NEG_INFINITY,
    }
}

/// As [`signed_depth`], in a mesh; the distance is measured first, which is cheaper than the rays
/// that decide on which side a point is.
fn depth_in_mesh(mesh: &MeshSolid, point: DVec3, needed: f64) -> f64 {
    let distance = mesh.surface.distance_to_local_point(point, false);
    if is_at_most(distance, needed) {
        return distance;
    }
    let is_inside = mesh.is_closed && is_inside_mesh(&mesh.surface, &Pose::IDENTITY, point);
    if is_inside { distance } else { -distance }
}

/// The triangles of a solid's surface that may reach into a box, in its own frame. A round solid is
/// replaced by a polyhedron.
fn triangles_near(solid: &Solid, near: &Bounds) -> Vec<[DVec3; 3]> {
    match solid {
        Solid::Mesh(mesh) => {
            let region = Aabb::new(near.low, near.high);
            let found = mesh.surface.bvh().intersect_aabb(&region);
            let triangles = found.map(|index| mesh.surface.triangle(index));
            triangles.map(|triangle| [triangle.a, triangle.b, triangle.c]).collect()
        }
        Solid::Convex(convex) => {
            let reaches = |triangle: &[DVec3; 3]| {
                is_at_most(near.distance(&Bounds::of_points(*triangle)), 0.0)
            };
            convex.surface().into_iter().filter(reaches).collect()
        }
    }
}

/// The part of a triangle in a box: a convex polygon (Sutherland and Hodgman's clipping).
fn clipped(triangle: &[DVec3; 3], near: &Bounds) -> Vec<DVec3> {
    let mut part = triangle.to_vec();
    for axis in 0..3 {
        for (sign, limit) in [(1.0, near.high[axis]), (-1.0, -near.low[axis])] {
            let inside = |at: DVec3| limit - sign * at[axis];
            let polygon = std::mem::take(&mut part);
            for (index, &here) in polygon.iter().enumerate() {
                let next = polygon[(index + 1) % polygon.len()];
                let (a, b) = (inside(here), inside(next));
                if a >= 0.0 {
                    part.push(here);
                }
                if a * b < 0.0 {
                    part.push(here + (next - here) * (a / (a - b)));
                }
            }
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::Shape;

    use super::*;
    use crate::check_robot::mesh;

    type Placed = (Solid, SolidPose);

    fn place(shape: &Shape, at: [f64; 3]) -> Placed {
        let solid = Solid::new(shape).unwrap();
        let pose = Pose::from_translation(at.into());
        let bounds = solid.local_bounds().transformed(&pose);
        (solid, SolidPose { world_from_solid: pose, bounds })
    }

    fn cuboid(half: [f64; 3]) -> Shape {
        Shape::Box { half_extents: half.into() }
    }

    fn distance(a: &Placed, b: &Placed) -> f64 {
        solid_separation((&a.0, &a.1), (&b.0, &b.1), DVec3::X, 0.1).distance
    }

    #[test]
    fn a_meshed_box_is_closed_and_faces_outwards() {
        let (solid, _) = place(&mesh([0.1, 0.2, 0.3], 3), [0.0; 3]);
        let Solid::Mesh(mesh) = &solid else { unreachable!() };
        assert!(mesh.is_closed);
        assert!((depth_in_mesh(mesh, DVec3::ZERO, 0.0) - 0.1).abs() < 1e-9);
        assert!((depth_in_mesh(mesh, DVec3::new(0.15, 0.0, 0.0), -1.0) + 0.05).abs() < 1e-9);
    }

    #[test]
    fn a_thin_sheet_in_a_mesh_is_deep_in_it() {
        let sheet = place(&cuboid([0.0019, 0.04, 0.009]), [0.0, 0.0, 0.009]);
        for count in [1, 8] {
            let foot = place(&mesh([0.11, 0.07, 0.02], count), [0.0, 0.0, 0.02]);
            let found = distance(&foot, &sheet);
            assert!(found < -0.015, "{found}");
        }
    }

    #[test]
    fn a_rail_of_small_triangles_in_a_mesh_is_deep_in_it() {
        let foot = place(&mesh([0.11, 0.07, 0.02], 2), [0.0; 3]);
        let rail = place(&mesh([0.01, 0.04, 0.006], 6), [0.0, 0.0, -0.015]);
        let found = distance(&foot, &rail);
        assert!(found < -0.009, "{found}");
    }

    #[test]
    fn a_thin_fin_in_a_meshed_wall_is_as_deep_as_the_wall_is_thick() {
        let wall = place(&mesh([0.006, 0.1, 0.035], 1), [0.0; 3]);
        let fin = |x: f64| place(&cuboid([0.0018, 0.05, 0.015]), [x, 0.0, 0.0]);
        let found = distance(&fin(0.0), &wall);
        assert!(found < -0.004, "{found}");
        assert!(distance(&fin(0.008), &wall) > 0.0);
    }

    #[test]
    fn a_mesh_that_touches_a_floor_is_not_deep_in_it() {
        let floor = place(&cuboid([5.0, 5.0, 0.25]), [0.0, 0.0, -0.25]);
        for depth in [0.0, 0.0005, 0.0015] {
            let foot = place(&mesh([0.11, 0.07, 0.02], 3), [0.0, 0.0, 0.02 - depth]);
            let found = distance(&foot, &floor);
            assert!((found + depth).abs() < 1e-6, "{found}");
        }
    }

    #[test]
    fn finely_meshed_bodies_in_each_other_are_deep() {
        let a = place(&mesh([0.5; 3], 4), [0.0; 3]);
        let b = place(&mesh([0.5; 3], 4), [0.1, 0.2, 0.7]);
        let found = body_separation((&a.0, &a.1), (&b.0, &b.1), DVec3::Z, 0.1);
        assert!((found.distance + 0.3).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn round_solids_are_sampled() {
        let box_mesh = place(&mesh([0.1; 3], 2), [0.0; 3]);
        let round = [
            Shape::Sphere { radius: 0.02 },
            Shape::Capsule { radius: 0.005, half_length: 0.2 },
            Shape::Cylinder { radius: 0.02, half_length: 0.03 },
        ];
        for shape in round {
            let found = distance(&place(&shape, [0.0, 0.0, 0.05]), &box_mesh);
            assert!(found < -0.01, "{shape:?}: {found}");
        }
    }
    #[test]
    fn a_thin_mesh_inside_another_one_is_as_deep_as_the_way_out() {
        let block = place(&mesh([0.1, 0.1, 0.1], 1), [0.0; 3]);
        let fin = place(&mesh([0.0005, 0.12, 0.05], 1), [0.02, 0.0, 0.0]);
        let found = body_separation((&block.0, &block.1), (&fin.0, &fin.1), DVec3::X, 0.1);
        assert!((found.distance + 0.0805).abs() < 1e-9, "{found:?}");
    }

    /// A solid turned about z.
    fn turned(shape: &Shape, at: [f64; 3], angle: f64) -> Placed {
        let (solid, _) = place(shape, at);
        let pose = Pose::from_parts(at.into(), glam::DQuat::from_rotation_z(angle));
        let bounds = solid.local_bounds().transformed(&pose);
        (solid, SolidPose { world_from_solid: pose, bounds })
    }

    #[test]
    fn the_depth_is_the_measured_one_whatever_is_known() {
        let solids = [
            place(&mesh([0.1, 0.06, 0.04], 3), [0.0; 3]),
            turned(&mesh([0.05, 0.05, 0.05], 2), [0.08, 0.03, 0.01], 0.4),
            turned(&cuboid([0.03, 0.09, 0.02]), [-0.07, 0.02, 0.01], 0.7),
            place(&Shape::Capsule { radius: 0.02, half_length: 0.1 }, [0.0, 0.05, 0.02]),
            place(&cuboid([0.02; 3]), [0.5, 0.0, 0.0]),
        ];
        for (a, b) in (0..5).flat_map(|a| (0..5).map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let (a, b) = ((&solids[a].0, &solids[a].1), (&solids[b].0, &solids[b].1));
            let hint = (b.1.bounds.centre() - a.1.bounds.centre()).normalize_or(DVec3::X);
            let measured = (-body_separation(a, b, hint, 0.0).distance).max(0.0);
            for known in [0.0, 0.5 * measured, measured, measured + 0.01] {
                let depth = body_depth(a, b, known);
                assert!((depth - known.max(measured)).abs() < 1e-9, "{depth} {known} {measured}");
            }
        }
    }

    #[test]
    fn a_point_deep_in_a_large_triangle_is_found() {
        // A pin of 8 mm stands beside the middle of a face of 0.8 m.
        let wall = place(&mesh([0.4, 0.4, 0.05], 1), [0.0; 3]);
        for at in [[0.137, 0.071], [-0.2931, 0.3117]] {
            let pin = place(&cuboid([0.004, 0.004, 0.1]), [at[0], at[1], 0.12]);
            let found = distance(&wall, &pin);
            assert!((found + 0.03).abs() < 1e-6, "{found}");
        }
    }

    #[test]
    fn the_depth_of_a_point_in_a_convex_solid_is_its_distance_to_the_surface() {
        let corner = |bits: u32| {
            DVec3::new(f64::from(bits & 1), f64::from(bits >> 1 & 1), f64::from(bits >> 2)) - 0.5
        };
        let depths = |shape: &Shape, points: &[[f64; 3]]| -> Vec<f64> {
            let Solid::Convex(convex) = Solid::new(shape).unwrap() else { unreachable!() };
            points.iter().map(|at| depth_in_convex(&convex, (*at).into())).collect()
        };
        let near = |found: Vec<f64>, expected: &[f64]| {
            let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(close, "{found:?} {expected:?}");
        };
        let ball = Shape::Sphere { radius: 0.5 };
        near(depths(&ball, &[[0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.0, 0.7]]), &[0.5, 0.2, -0.2]);
        let capsule = Shape::Capsule { radius: 0.5, half_length: 1.0 };
        let points = [[0.3, 0.0, 0.8], [0.0, 0.3, -1.0], [0.0, 0.0, 1.2], [0.0, 0.0, -1.2]];
        near(depths(&capsule, &points), &[0.2, 0.2, 0.3, 0.3]);
        let cylinder = Shape::Cylinder { radius: 0.5, half_length: 1.0 };
        let points = [[0.3, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, -0.9], [0.3, 0.4, 0.0]];
        near(depths(&cylinder, &points), &[0.2, 0.1, 0.1, 0.0]);
        let points = [[0.4, 0.0, 0.0], [0.0, -0.45, 0.1], [0.0, 0.0, 0.75]];
        near(depths(&cuboid([0.5; 3]), &points), &[0.1, 0.05, -0.25]);
        let hull = Shape::ConvexHull { points: (0..8).map(corner).collect(), source: None };
        near(depths(&hull, &points), &[0.1, 0.05, -0.25]);
    }

    #[test]
    fn a_hull_is_deep_in_a_mesh_and_a_mesh_in_a_hull() {
        let corner = |bits: u32| {
            DVec3::new(f64::from(bits & 1), f64::from(bits >> 1 & 1), f64::from(bits >> 2)) - 0.5
        };
        let hull = place(
            &Shape::ConvexHull {
                points: (0..8).map(|bits| 0.1 * corner(bits)).collect(),
                source: None,
            },
            [0.0, 0.0, 0.13],
        );
        let block = place(&mesh([0.1; 3], 2), [0.0; 3]);
        for (a, b) in [(&hull, &block), (&block, &hull)] {
            assert!((distance(a, b) + 0.02).abs() < 1e-9, "{}", distance(a, b));
        }
        // A solid that a mesh holds wholly is found by its middle.
        let (small, far) = (place(&cuboid([0.01; 3]), [0.05, 0.0, 0.0]), [0.3, 0.0, 0.0]);
        assert!((distance(&small, &block) + 0.06).abs() < 1.5e-3, "{}", distance(&small, &block));
        assert!(distance(&place(&cuboid([0.01; 3]), far), &block) > 0.05);
        // An open mesh has no inside.
        let Shape::Mesh { vertices, mut triangles, source } = mesh([0.1; 3], 2) else {
            unreachable!()
        };
        triangles.pop();
        let open = place(&Shape::Mesh { vertices, triangles, source }, [0.0; 3]);
        assert!(distance(&small, &open) > 0.03);
        assert_eq!(deepest_of_first((&small.0, &small.1), (&open.0, &open.1), 0.0), 0.0);
    }

    #[test]
    fn a_clipped_triangle_is_its_part_in_the_box() {
        let mut random = crate::check_robot::randoms(8);
        let [mut cut, mut inside] = [0; 2];
        for _ in 0..400 {
            let mut vector = |size: f64| DVec3::from_array([0; 3].map(|_| random(-size, size)));
            let near = Bounds::of_points([vector(1.0), vector(1.0)]);
            let triangle = [vector(1.5), vector(1.5), vector(1.5)];
            let part = clipped(&triangle, &near);
            let [a, b, c] = triangle;
            let area = |corners: &[DVec3]| {
                let fan = corners.windows(2).skip(1);
                fan.map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]).length())
                    .sum::<f64>()
            };
            // Every corner is a point of the triangle in the box.
            for at in &part {
                assert!((at.clamp(near.low, near.high) - *at).length() < 1e-9, "{at}");
                let of_parts = area(&[a, b, *at]) + area(&[b, c, *at]) + area(&[c, a, *at]);
                assert!((of_parts - area(&triangle)).abs() < 1e-9, "{at}");
            }
            // The part has the area of the points of the triangle that lie in the box.
            let grid = (0..60).flat_map(|i| (0..60 - i).map(move |k| (i, k)));
            let points = grid.map(|(i, k)| {
                let [u, v] = [i, k].map(|at| (f64::from(at) + 1.0 / 3.0) / 60.0);
                a + u * (b - a) + v * (c - a)
            });
            let (all, within) = points.fold((0, 0), |(all, within), at| {
                (all + 1, within + u32::from(at == at.clamp(near.low, near.high)))
            });
            let share = f64::from(within) / f64::from(all);
            assert!((area(&part) / area(&triangle) - share).abs() < 0.08, "{part:?} {share}");
            cut += u32::from(part.len() > 3);
            inside += u32::from(!part.is_empty());
        }
        assert!(cut > 30 && inside > 60, "{cut} {inside}");
    }
}
