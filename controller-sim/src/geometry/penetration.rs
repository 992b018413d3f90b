//! The depth of solids of which surfaces cross.
//!
//! The triangles of a mesh have no thickness, so the depth of a triangle in another solid does not
//! measure the overlap of the solids. Here the depth is that of the deepest sample of one surface
//! inside the other solid: the distance of the sample to the surface of that solid.

use glam::DVec3;
use parry3d_f64::query::PointQuery;
use surefoot_shared_types::Pose;

use crate::geometry::body::SolidPose;
use crate::geometry::bounds::Bounds;
use crate::geometry::mesh_solid::MeshSolid;
use crate::geometry::separation::{Separation, convex_separation, is_inside_mesh, separation};
use crate::geometry::solid::{Convex, Core, Solid};

/// Spacing of the samples on a surface, m.
const SAMPLE_SPACING: f64 = 3e-3;
/// Most samples along a side of a triangle; a larger triangle is sampled more coarsely.
const SIDE_SAMPLES_MAX: usize = 64;
/// Triangles that overlap less than this count as touching, m.
const CROSSING_DEPTH_MIN: f64 = 1e-4;

/// As [`separation`], but where one solid is a mesh, and the surfaces cross or one solid lies
/// inside the mesh, the depth is at least that of [`deepest_sample`].
pub fn solid_separation(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
) -> Separation {
    let found = separation(a, b, hint, enough);
    let is_mesh = |solid: &Solid| matches!(solid, Solid::Mesh(_));
    if !(is_mesh(a.0) || is_mesh(b.0)) {
        return found;
    }
    let overlaps =
        found.distance < -CROSSING_DEPTH_MIN || has_middle_of(a, b) || has_middle_of(b, a);
    if !overlaps {
        return found;
    }
    Separation { distance: found.distance.min(-deepest_sample(a, b)), ..found }
}

/// As [`solid_separation`], for bodies that do not stand on each other: where triangles of two
/// meshes cross, the depth is that of the boxes around the meshes, a translation that separates
/// them.
pub fn body_separation(
    a: (&Solid, &SolidPose),
    b: (&Solid, &SolidPose),
    hint: DVec3,
    enough: f64,
) -> Separation {
    if !matches!((a.0, b.0), (Solid::Mesh(_), Solid::Mesh(_))) {
        return solid_separation(a, b, hint, enough);
    }
    let found = separation(a, b, hint, enough);
    if found.distance >= 0.0 {
        return found;
    }
    Separation { distance: -a.1.bounds.penetration(&b.1.bounds), ..found }
}

/// Whether the middle of a solid lies inside a closed mesh whose box holds the box of the solid.
fn has_middle_of((mesh, placed): (&Solid, &SolidPose), (_, other): (&Solid, &SolidPose)) -> bool {
    let Solid::Mesh(mesh) = mesh else { return false };
    mesh.is_closed
        && placed.bounds.holds(&other.bounds)
        && is_inside_mesh(&mesh.surface, &placed.world_from_solid, other.bounds.centre())
}

/// The depth of the deepest sample of either surface inside the other solid, m; 0 where no sample
/// lies inside.
pub fn deepest_sample(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose)) -> f64 {
    depth_of_first(a, b).max(depth_of_first(b, a))
}

/// The depth of the deepest sample of the surface of `a` inside `b`.
fn depth_of_first(a: (&Solid, &SolidPose), b: (&Solid, &SolidPose)) -> f64 {
    let world_from_a = a.1.world_from_solid;
    let near = b.1.bounds.transformed(&world_from_a.inverse());
    let mut deepest: f64 = 0.0;
    for triangle in surface(a.0) {
        for at in samples(&triangle, &near) {
            deepest = deepest.max(depth_of_point(world_from_a * at, b));
        }
    }
    deepest
}

/// The distance of a point (in the world, m) inside a solid to its surface; 0 outside.
fn depth_of_point(point: DVec3, (solid, placed): (&Solid, &SolidPose)) -> f64 {
    match solid {
        Solid::Convex(convex) => {
            depth_in_convex(convex, placed.world_from_solid.inverse() * point).max(0.0)
        }
        Solid::Mesh(mesh) => depth_in_mesh(mesh, &placed.world_from_solid, point),
    }
}

/// The distance of a point (in the frame of the solid, m) inside a convex solid to its surface;
/// negative outside.
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
        Core::Triangle(_) => {
            let vertex = Convex { core: Core::Segment(0.0), radius: 0.0 };
            let pose = Pose::from_translation(point);
            let solid = (convex, &Pose::IDENTITY);
            -convex_separation((&vertex, &pose), solid, DVec3::Z, 0.0).distance
        }
    }
}

fn depth_in_mesh(mesh: &MeshSolid, world_from_mesh: &Pose, point: DVec3) -> f64 {
    if !mesh.is_closed || !is_inside_mesh(&mesh.surface, world_from_mesh, point) {
        return 0.0;
    }
    let local = world_from_mesh.inverse() * point;
    mesh.surface.distance_to_local_point(local, false)
}

/// The triangles of a solid's surface, in its own frame. A round solid is replaced by a polyhedron.
fn surface(solid: &Solid) -> Vec<[DVec3; 3]> {
    match solid {
        Solid::Mesh(mesh) => {
            mesh.surface.triangles().map(|triangle| [triangle.a, triangle.b, triangle.c]).collect()
        }
        Solid::Convex(convex) => convex.surface(),
    }
}

/// Samples of the part of a triangle that lies in a box, its corners among them.
fn samples(triangle: &[DVec3; 3], near: &Bounds) -> Vec<DVec3> {
    if near.distance(&Bounds::of_points(*triangle)) > 0.0 {
        return Vec::new();
    }
    let part = clipped(triangle, near);
    let Some((&first, rest)) = part.split_first() else { return Vec::new() };
    rest.windows(2).flat_map(|pair| grid([first, pair[0], pair[1]])).collect()
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

/// Points of a triangle at most [`SAMPLE_SPACING`] apart along its sides.
fn grid([a, b, c]: [DVec3; 3]) -> Vec<DVec3> {
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    let count = ((longest / SAMPLE_SPACING).ceil() as usize).clamp(1, SIDE_SAMPLES_MAX);
    let step = 1.0 / count as f64;
    let places = (0..=count).flat_map(|i| (0..=count - i).map(move |k| (i as f64, k as f64)));
    places.map(|(i, k)| a + i * step * (b - a) + k * step * (c - a)).collect()
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::Shape;

    use super::*;

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

    /// A box as a closed mesh, each face of `count` by `count` squares.
    fn mesh(half: [f64; 3], count: usize) -> Shape {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut corner = |i: usize, k: usize| {
                    let along = |k: usize| (2.0 * k as f64 - count as f64) / count as f64;
                    let mut at = DVec3::ZERO;
                    at[axis] = sign;
                    (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (along(i), sign * along(k));
                    vertices.push(at * DVec3::from(half));
                    vertices.len() as u32 - 1
                };
                for (i, k) in (0..count).flat_map(|i| (0..count).map(move |k| (i, k))) {
                    let quad =
                        [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
                    triangles.push([quad[0], quad[1], quad[2]]);
                    triangles.push([quad[0], quad[2], quad[3]]);
                }
            }
        }
        let source = None;
        Shape::Mesh { vertices, triangles, source }
    }

    fn distance(a: &Placed, b: &Placed) -> f64 {
        solid_separation((&a.0, &a.1), (&b.0, &b.1), DVec3::X, 0.1).distance
    }

    #[test]
    fn a_meshed_box_is_closed_and_faces_outwards() {
        let (solid, placed) = place(&mesh([0.1, 0.2, 0.3], 3), [0.0; 3]);
        let Solid::Mesh(mesh) = &solid else { unreachable!() };
        assert!(mesh.is_closed);
        assert!((depth_in_mesh(mesh, &placed.world_from_solid, DVec3::ZERO) - 0.1).abs() < 1e-9);
        assert_eq!(depth_in_mesh(mesh, &placed.world_from_solid, DVec3::splat(0.15)), 0.0);
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
}
