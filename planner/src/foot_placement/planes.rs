//! The planes that a sole may lie in near the ideal, and the features seen in them.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::spatial::yaw_of;

use crate::foot_placement::elements::{CurvedSurface, Element};
use crate::foot_placement::plane_features::{Footprint, Plane, pose_on_plane};
use crate::foot_placement::request::PlacementQuery;
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_fit::narrowest_direction;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::TANGENT_SURFACES_MAX;

/// Lists the planes of the gathered features, then those tangent to two curved features.
pub(crate) fn list_planes(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery) {
    scratch.planes.nearest.clear();
    let mut curved_surfaces: heapless::Vec<CurvedSurface, TANGENT_SURFACES_MAX> =
        heapless::Vec::new();
    let ideal = (query.ideal.translation, yaw_of(query.ideal.rotation));
    for i in 0..scratch.features.len() {
        match surfaces.element(scratch.features[i].1) {
            Element::Face(face, vertices) => {
                add_plane(surfaces, scratch, ideal, face.normal, vertices[0])
            }
            Element::Curved(curved) => {
                if let Some(normal) = curved.side_normal(DVec3::Z) {
                    add_plane(surfaces, scratch, ideal, normal, curved.line_with_normal(normal)[0]);
                }
                let _ignored_beyond_the_nearest = curved_surfaces.push(*curved);
            }
        }
    }
    for (i, one) in curved_surfaces.iter().enumerate() {
        for other in &curved_surfaces[..i] {
            if let Some(normal) = common_tangent(one, other) {
                add_plane(surfaces, scratch, ideal, normal, one.line_with_normal(normal)[0]);
            }
        }
    }
}

/// Adds a plane near the ideal position and heading unless it is too steep or known already.
fn add_plane(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    (ideal, yaw): (DVec3, f64),
    normal: DVec3,
    point: DVec3,
) {
    if !surfaces.is_flat_enough(normal) {
        return;
    }
    let below = ideal.truncate() - point.truncate();
    let height = point.z - normal.truncate().dot(below) / normal.z;
    let origin = ideal.truncate().extend(height);
    let tolerance = surfaces.config().plane_distance_max;
    let is_same = |p: &Plane| {
        let apart = (point - p.world_from_plane.translation).dot(p.normal).abs();
        p.normal.dot(normal) >= surfaces.coplanar_cos
            && apart <= tolerance
            && (p.world_from_plane.translation.z - height).abs() <= tolerance
    };
    if !scratch.planes.nearest.iter().any(is_same) {
        let world_from_plane = pose_on_plane(origin, normal, yaw);
        scratch.planes.nearest.push(Plane {
            world_from_plane,
            normal,
            distance: (height - ideal.z).abs() * normal.z,
        });
    }
}

/// Lists the gathered features that lie in a plane, seen in it, nearest first.
pub(crate) fn list_footprints(surfaces: &Surfaces, scratch: &mut Scratch, plane: &Plane) {
    scratch.planes.footprints.clear();
    let tolerance = surfaces.config().plane_distance_max;
    let in_plane = |p: DVec3| plane.world_from_plane.inverse_transform_point(p);
    for i in 0..scratch.features.len() {
        let mut outline = heapless::Vec::new();
        match surfaces.element(scratch.features[i].1) {
            Element::Face(face, vertices) => {
                let is_in_plane = |&v: &DVec3| {
                    (v - plane.world_from_plane.translation).dot(plane.normal).abs() <= tolerance
                };
                if face.normal.dot(plane.normal) >= surfaces.coplanar_cos
                    && vertices.iter().any(is_in_plane)
                {
                    outline.extend(vertices.iter().map(|&v| in_plane(v).truncate()));
                }
            }
            Element::Curved(curved) => {
                let normal = curved
                    .side_normal(plane.normal)
                    .filter(|n| n.dot(plane.normal) >= surfaces.coplanar_cos);
                let top = normal.map(|n| curved.line_with_normal(n).map(in_plane));
                let top = top.filter(|ends| ends.iter().all(|p| p.z.abs() <= tolerance));
                outline.extend(top.iter().flatten().map(|p| p.truncate()));
            }
        }
        if !outline.is_empty() {
            let across = narrowest_direction(&outline).unwrap_or(DVec2::X);
            scratch.planes.footprints.push(Footprint { outline, across });
        }
    }
}

/// The upward normal of the plane that touches two parallel curved surfaces, or two balls, from
/// above.
fn common_tangent(one: &CurvedSurface, other: &CurvedSurface) -> Option<DVec3> {
    let along = match (one.direction(), other.direction()) {
        (Some(d), Some(e)) if d.dot(e).abs() > 0.9998 => d,
        (None, None) => (other.a - one.a).cross(DVec3::Z).try_normalize()?,
        _ => return None,
    };
    let between = other.a - one.a;
    let between = between - along * between.dot(along);
    let distance = between.length();
    let lean = (one.radius - other.radius) / distance;
    if distance < 1e-6 || lean.abs() >= 1.0 {
        return None;
    }
    let direction = between / distance;
    let side = along.cross(direction);
    let side = if side.z < 0.0 { -side } else { side };
    Some(direction * lean + side * (1.0 - lean * lean).sqrt())
}
