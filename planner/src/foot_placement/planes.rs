//! The planes that a sole may lie in near the ideal, and the features seen in them.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::foot_placement::propose::PlacementQuery;
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_fit::{extent, narrowest_direction};
use crate::foot_placement::sole_support::pose_on_plane;
use crate::foot_placement::surfaces::{CurvedSurface, Element, Surfaces};
use crate::geometry::polygon::FACE_VERTICES_MAX;

/// Most curved features whose common tangent planes are tried.
const TANGENT_SURFACES_MAX: usize = 8;

/// A plane that a sole may lie in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Origin straight above or below the ideal position, z its normal, x the ideal heading.
    pub world_from_plane: Pose,
    /// The normal in the world.
    pub normal: DVec3,
    /// How far the ideal position is from it, m: no candidate in it costs less.
    pub distance: f64,
}

/// A feature seen in a plane.
#[derive(Debug, Clone)]
pub(crate) struct Footprint {
    /// A face's outline, a line's two ends, or a point; in the plane frame.
    pub outline: heapless::Vec<DVec2, FACE_VERTICES_MAX>,
    /// The unit direction across its narrow side.
    pub across: DVec2,
}

impl Footprint {
    /// Its extent along a direction, m.
    pub fn extent(&self, direction: DVec2) -> [f64; 2] {
        extent(self.outline.iter().copied(), direction)
    }
}

impl Surfaces {
    /// The planes of the gathered features, nearest first, then those tangent to two curved
    /// features.
    pub(crate) fn list_planes(&self, scratch: &mut Scratch, query: &PlacementQuery) {
        scratch.planes.clear();
        let mut curved_surfaces: heapless::Vec<CurvedSurface, TANGENT_SURFACES_MAX> =
            heapless::Vec::new();
        let ideal = (query.ideal.translation, yaw_of(query.ideal.rotation));
        for i in 0..scratch.features.len() {
            match self.element(scratch.features[i].1) {
                Element::Face(face, vertices) => {
                    self.add_plane(scratch, ideal, face.normal, vertices[0])
                }
                Element::Curved(curved) => {
                    if let Some(normal) = curved.side_normal(DVec3::Z) {
                        self.add_plane(scratch, ideal, normal, curved.line_with_normal(normal)[0]);
                    }
                    let _ignored_beyond_the_nearest = curved_surfaces.push(*curved);
                }
            }
        }
        for (i, one) in curved_surfaces.iter().enumerate() {
            for other in &curved_surfaces[..i] {
                if let Some(normal) = common_tangent(one, other) {
                    self.add_plane(scratch, ideal, normal, one.line_with_normal(normal)[0]);
                }
            }
        }
    }

    /// Adds a plane near the ideal position and heading unless it is too steep or known already.
    fn add_plane(
        &self,
        scratch: &mut Scratch,
        (ideal, yaw): (DVec3, f64),
        normal: DVec3,
        point: DVec3,
    ) {
        if !self.is_flat_enough(normal) {
            return;
        }
        let below = ideal.truncate() - point.truncate();
        let height = point.z - normal.truncate().dot(below) / normal.z;
        let origin = ideal.truncate().extend(height);
        let tolerance = self.config.plane_distance_max;
        let is_same = |p: &Plane| {
            let apart = (point - p.world_from_plane.translation).dot(p.normal).abs();
            p.normal.dot(normal) >= self.coplanar_cos
                && apart <= tolerance
                && (p.world_from_plane.translation.z - height).abs() <= tolerance
        };
        if !scratch.planes.iter().any(is_same) {
            let world_from_plane = pose_on_plane(origin, normal, yaw);
            scratch.planes.push(Plane {
                world_from_plane,
                normal,
                distance: (height - ideal.z).abs() * normal.z,
            });
        }
    }

    /// The gathered features that lie in a plane, as seen in it, nearest first.
    pub(crate) fn list_footprints(&self, scratch: &mut Scratch, plane: &Plane) {
        scratch.footprints.clear();
        let tolerance = self.config.plane_distance_max;
        let in_plane = |p: DVec3| plane.world_from_plane.inverse_transform_point(p);
        for i in 0..scratch.features.len() {
            let mut outline = heapless::Vec::new();
            match self.element(scratch.features[i].1) {
                Element::Face(face, vertices) => {
                    let is_in_plane = |&v: &DVec3| {
                        (v - plane.world_from_plane.translation).dot(plane.normal).abs()
                            <= tolerance
                    };
                    if face.normal.dot(plane.normal) >= self.coplanar_cos
                        && vertices.iter().any(is_in_plane)
                    {
                        outline.extend(vertices.iter().map(|&v| in_plane(v).truncate()));
                    }
                }
                Element::Curved(curved) => {
                    let normal = curved
                        .side_normal(plane.normal)
                        .filter(|n| n.dot(plane.normal) >= self.coplanar_cos);
                    let top = normal.map(|n| curved.line_with_normal(n).map(in_plane));
                    let top = top.filter(|ends| ends.iter().all(|p| p.z.abs() <= tolerance));
                    outline.extend(top.iter().flatten().map(|p| p.truncate()));
                }
            }
            if !outline.is_empty() {
                let across = narrowest_direction(&outline).unwrap_or(DVec2::X);
                scratch.footprints.push(Footprint { outline, across });
            }
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
