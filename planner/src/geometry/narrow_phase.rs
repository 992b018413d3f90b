//! Whether two solids come within a margin of each other.
//!
//! A negative answer is certain: it follows from a closed form, or from the measured distance along
//! a separating direction. So an iteration limit, a degenerate simplex and NaN give a positive
//! answer.

use glam::{DMat3, DQuat, DVec3};
use parry3d_f64::query::gjk;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use surefoot_shared_types::Pose;

use crate::geometry::bvh::Aabb;
use crate::geometry::distance::{
    LineSegment, box_box_separation, exceeds, point_box_distance_squared,
    point_triangle_distance_squared, segment_box_distance_squared,
    segment_segment_distance_squared, segment_triangle_distance_squared,
};
use crate::geometry::solid::{Convex, Core, Solid};
use crate::geometry::triangle_mesh::Mesh;

/// Whether the distance of two solids is at most `margin` (m, at least 0). Solids that touch or
/// contain each other have distance 0.
pub fn is_within(a: &Solid, b: &Solid, a_from_b: &Pose, margin: f64) -> bool {
    match (a, b) {
        (Solid::Convex(a), Solid::Convex(b)) => convex_within(a, b, a_from_b, margin),
        (Solid::Mesh(mesh), Solid::Convex(convex)) => {
            mesh_within(mesh, convex, a_from_b, margin) || mesh_contains(mesh, b, a_from_b)
        }
        (Solid::Convex(_), Solid::Mesh(_)) => is_within(b, a, &a_from_b.inverse(), margin),
        (Solid::Mesh(mesh_a), Solid::Mesh(mesh_b)) => {
            meshes_within(mesh_a, mesh_b, a_from_b, margin)
                || mesh_contains(mesh_a, b, a_from_b)
                || mesh_contains(mesh_b, a, &a_from_b.inverse())
        }
    }
}

fn mesh_contains(mesh: &Mesh, solid: &Solid, mesh_from_solid: &Pose) -> bool {
    mesh.contains(*mesh_from_solid * solid.point_inside())
}

/// Whether a segment in a solid's frame comes within `reach` (m) of the solid.
pub fn segment_within(solid: &Solid, segment: LineSegment, reach: f64) -> bool {
    if let Solid::Convex(Convex { core: Core::Box { half_extents }, radius }) = solid {
        let reach = reach + radius;
        return !exceeds(segment_box_distance_squared(segment, *half_extents), reach * reach);
    }
    let half_length = 0.5 * segment.delta.length();
    let core = if half_length > 0.0 { Core::LineSegment { half_length } } else { Core::Point };
    let rotation =
        DQuat::from_rotation_arc(DVec3::Z, segment.delta.try_normalize().unwrap_or(DVec3::Z));
    let frame = Pose::from_parts(segment.start + 0.5 * segment.delta, rotation);
    is_within(solid, &Solid::Convex(Convex { core, radius: 0.0 }), &frame, reach)
}

/// Whether any triangle of the mesh comes within the margin of a convex solid.
fn mesh_within(mesh: &Mesh, convex: &Convex, mesh_from_convex: &Pose, margin: f64) -> bool {
    let reach = convex.radius + margin;
    let core_bounds = convex.core.aabb();
    let region = transformed(core_bounds, mesh_from_convex).grown(reach);
    let convex_from_mesh = mesh_from_convex.inverse();
    let rotation = DMat3::from_quat(convex_from_mesh.rotation);
    let near = core_bounds.grown(reach);
    mesh.any_triangle_near(&region, |corners| {
        let corners = corners.map(|corner| rotation * corner + convex_from_mesh.translation);
        Aabb::of_points(corners).overlaps(&near) && triangle_within(&convex.core, corners, reach)
    })
}

fn meshes_within(a: &Mesh, b: &Mesh, a_from_b: &Pose, margin: f64) -> bool {
    let region = transformed(b.aabb(), a_from_b).grown(margin);
    let b_from_a = a_from_b.inverse();
    a.any_triangle_near(&region, |corners| {
        let triangle = Convex { core: Core::Triangle(corners), radius: 0.0 };
        mesh_within(b, &triangle, &b_from_a, margin)
    })
}

/// Whether a triangle in the core's frame comes within `reach` of the core.
fn triangle_within(core: &Core, corners: [DVec3; 3], reach: f64) -> bool {
    let reach_squared = reach * reach;
    match core {
        Core::Point => {
            !exceeds(point_triangle_distance_squared(DVec3::ZERO, corners), reach_squared)
        }
        Core::LineSegment { half_length } => !exceeds(
            segment_triangle_distance_squared(
                LineSegment::along_z(&Pose::IDENTITY, *half_length),
                corners,
            ),
            reach_squared,
        ),
        _ => {
            !is_beyond_plane(core, corners, reach)
                && gjk_within(core, &Core::Triangle(corners), &Pose::IDENTITY, reach)
        }
    }
}

/// Whether the core is farther than `reach` (m) from the triangle's plane.
fn is_beyond_plane(core: &Core, [a, b, c]: [DVec3; 3], reach: f64) -> bool {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let height = normal.dot(a);
    let above = normal.dot(core.local_support_point(-normal)) - height;
    let below = height - normal.dot(core.local_support_point(normal));
    above.max(below) > reach
}

fn convex_within(a: &Convex, b: &Convex, a_from_b: &Pose, margin: f64) -> bool {
    let reach = a.radius + b.radius + margin;
    let reach_squared = reach * reach;
    match (&a.core, &b.core) {
        (Core::Point, Core::Point) => {
            !exceeds(a_from_b.translation.length_squared(), reach_squared)
        }
        (Core::Point | Core::LineSegment { .. }, Core::Point | Core::LineSegment { .. }) => {
            let (a, b) = (segment_of(&a.core, &Pose::IDENTITY), segment_of(&b.core, a_from_b));
            !exceeds(segment_segment_distance_squared(a, b), reach_squared)
        }
        (Core::Box { half_extents }, Core::Point) => {
            !exceeds(point_box_distance_squared(a_from_b.translation, *half_extents), reach_squared)
        }
        (Core::Box { half_extents }, Core::LineSegment { half_length }) => !exceeds(
            segment_box_distance_squared(
                LineSegment::along_z(a_from_b, *half_length),
                *half_extents,
            ),
            reach_squared,
        ),
        (Core::Point | Core::LineSegment { .. }, Core::Box { .. }) => {
            convex_within(b, a, &a_from_b.inverse(), margin)
        }
        (Core::Box { half_extents: half_a }, Core::Box { half_extents: half_b }) => {
            let separation = box_box_separation(
                *half_a,
                *half_b,
                &DMat3::from_quat(a_from_b.rotation),
                a_from_b.translation,
            );
            separation <= 0.0
                || !exceeds(separation, reach) && gjk_within(&a.core, &b.core, a_from_b, reach)
        }
        _ => {
            !are_boxes_apart(&a.core, &b.core, a_from_b, reach)
                && gjk_within(&a.core, &b.core, a_from_b, reach)
        }
    }
}

/// Whether the bounding boxes of two cores are farther apart than `reach` (m).
fn are_boxes_apart(a: &Core, b: &Core, a_from_b: &Pose, reach: f64) -> bool {
    let (around_a, around_b) = (a.aabb(), b.aabb());
    let center = *a_from_b * around_b.center() - around_a.center();
    box_box_separation(
        around_a.half_extents(),
        around_b.half_extents(),
        &DMat3::from_quat(a_from_b.rotation),
        center,
    ) > reach
}

fn segment_of(core: &Core, frame: &Pose) -> LineSegment {
    match core {
        Core::LineSegment { half_length } => LineSegment::along_z(frame, *half_length),
        _ => LineSegment { start: frame.translation, delta: DVec3::ZERO },
    }
}

fn transformed(bounds: Aabb, pose: &Pose) -> Aabb {
    bounds.transformed(&DMat3::from_quat(pose.rotation), pose.translation)
}

/// A direction in the first solid's frame along which two convex solids are apart; `None` if GJK
/// finds none.
pub fn separating_direction(a: &Solid, b: &Solid, a_from_b: &Pose) -> Option<DVec3> {
    let (Solid::Convex(a), Solid::Convex(b)) = (a, b) else { return None };
    match closest(&a.core, &b.core, a_from_b, f64::INFINITY) {
        GJKResult::ClosestPoints(_, _, direction)
        | GJKResult::Proximity(direction)
        | GJKResult::NoIntersection(direction) => {
            (separation_along(&a.core, &b.core, a_from_b, direction) > 0.0).then_some(direction)
        }
        GJKResult::Intersection => None,
    }
}

/// The distance between two cores along a direction; negative if they overlap along it.
fn separation_along(a: &Core, b: &Core, a_from_b: &Pose, direction: DVec3) -> f64 {
    -direction.dot(CsoPoint::from_shapes(a_from_b, a, b, direction).point)
}

fn closest(a: &Core, b: &Core, a_from_b: &Pose, reach: f64) -> GJKResult {
    let start = a_from_b.translation.try_normalize().unwrap_or(DVec3::X);
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(a_from_b, a, b, start));
    gjk::closest_points(a_from_b, a, b, reach, true, &mut simplex)
}

/// GJK on two cores. Only the measured distance along the direction that it returns counts as
/// separation.
fn gjk_within(a: &Core, b: &Core, a_from_b: &Pose, reach: f64) -> bool {
    if !a_from_b.is_finite() {
        return true;
    }
    let direction = match closest(a, b, a_from_b, reach) {
        GJKResult::Intersection => return true,
        GJKResult::ClosestPoints(_, _, direction)
        | GJKResult::Proximity(direction)
        | GJKResult::NoIntersection(direction) => direction,
    };
    !exceeds(separation_along(a, b, a_from_b, direction), reach)
}
