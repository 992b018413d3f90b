//! Triangle meshes with a bounding volume hierarchy, and a point-in-mesh test for closed surfaces.

use std::cell::Cell;

use glam::DVec3;

use crate::geometry::bvh::{Aabb, Bvh};
use crate::geometry::distance::point_triangle_distance_squared;
use crate::geometry::tuning::LEAF_TRIANGLES_MAX;

/// A triangle mesh in its own frame.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    tree: Bvh,
    aabb: Aabb,
    is_closed: bool,
}

/// Smallest barycentric distance of a ray from an edge for a clear crossing.
const EDGE_TOLERANCE: f64 = 1e-9;
/// Directions of the rays, tried in order until one passes no edge. They are not parallel to common
/// directions of buildings and machines.
const RAYS: [DVec3; 4] = [
    DVec3::new(0.0131, 0.0277, 0.9995),
    DVec3::new(0.9981, 0.0343, 0.0507),
    DVec3::new(0.0411, 0.9963, 0.0753),
    DVec3::new(0.5871, 0.4213, -0.6917),
];

impl Mesh {
    /// Compiles a mesh, or returns the reason why it cannot be used.
    pub fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, String> {
        if triangles.is_empty() {
            return Err("has no triangles".into());
        }
        if vertices.iter().any(|vertex| !vertex.is_finite()) {
            return Err("has a vertex that is not finite".into());
        }
        if triangles.iter().flatten().any(|&index| index as usize >= vertices.len()) {
            return Err("has a triangle with a vertex that does not exist".into());
        }
        let corners = |triangle: &[u32; 3]| triangle.map(|index| vertices[index as usize]);
        let bounds: Vec<Aabb> =
            triangles.iter().map(|triangle| Aabb::of_points(corners(triangle))).collect();
        let aabb = bounds.iter().fold(Aabb::EMPTY, |all, one| all.union(*one));
        let tree = Bvh::new(&bounds, LEAF_TRIANGLES_MAX);
        Ok(Self {
            vertices: vertices.to_vec(),
            triangles: triangles.to_vec(),
            tree,
            aabb,
            is_closed: is_closed(vertices, triangles),
        })
    }

    /// The vertices, m.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Bounding box.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|index| self.vertices[index as usize])
    }

    /// Whether `accept` accepts a triangle whose bounding box overlaps `region`.
    pub fn any_triangle_near(
        &self,
        region: &Aabb,
        mut accept: impl FnMut([DVec3; 3]) -> bool,
    ) -> bool {
        self.tree
            .find(|bounds| bounds.overlaps(region), |triangle| accept(self.corners(triangle)))
            .is_some()
    }

    /// Whether a point lies inside of the closed surface; `true` in doubt, `false` for an open
    /// surface.
    pub fn contains(&self, point: DVec3) -> bool {
        if !self.is_closed || !self.aabb.contains(point) {
            return false;
        }
        RAYS.iter()
            .find_map(|&direction| self.winding_along(point, direction))
            .is_none_or(|winding| winding != 0)
    }

    /// Distance from the centre of the bounding box to the surface, m; 0 if it is not known to lie
    /// inside.
    pub fn inner_radius(&self) -> f64 {
        let center = self.aabb.center();
        let is_inside = |direction: &DVec3| {
            self.winding_along(center, *direction).is_some_and(|winding| winding != 0)
        };
        if !self.is_closed || !RAYS.iter().all(is_inside) {
            return 0.0;
        }
        let distances = (0..self.triangles.len())
            .map(|triangle| point_triangle_distance_squared(center, self.corners(triangle)));
        libm::sqrt(distances.fold(f64::INFINITY, f64::min))
    }

    /// The winding number of the surface about the start of a ray; `None` if the ray passes too
    /// close to an edge.
    fn winding_along(&self, start: DVec3, direction: DVec3) -> Option<i64> {
        let inverse = direction.recip();
        let winding = Cell::new(0);
        let is_unclear = |triangle: usize| match crossing(start, direction, self.corners(triangle))
        {
            Crossing::Miss => false,
            Crossing::Through(side) => {
                winding.set(winding.get() + side);
                false
            }
            Crossing::Unclear => true,
        };
        let unclear = self.tree.find(|bounds| ray_hits(bounds, start, inverse), is_unclear);
        unclear.is_none().then_some(winding.get())
    }

    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.vertices.as_slice())
            + size_of_val(self.triangles.as_slice())
            + self.tree.bytes()
    }
}

/// Whether every edge is used equally often in both directions; vertices with the same coordinates
/// are one.
fn is_closed(vertices: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let key = |vertex: DVec3| (vertex + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by_key(|&index| key(vertices[index as usize]));
    let mut welded = vec![0; vertices.len()];
    for pair in 0..order.len() {
        let is_same = pair > 0
            && key(vertices[order[pair] as usize]) == key(vertices[order[pair - 1] as usize]);
        welded[order[pair] as usize] =
            if is_same { welded[order[pair - 1] as usize] } else { order[pair] };
    }
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| welded[index as usize]);
        edges.extend(
            [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)),
        );
    }
    edges.retain(|&(from, to, _)| from != to);
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .all(|uses| 2 * uses.iter().filter(|one| one.2).count() == uses.len())
}

fn ray_hits(bounds: &Aabb, start: DVec3, inverse_direction: DVec3) -> bool {
    let (a, b) =
        ((bounds.min - start) * inverse_direction, (bounds.max - start) * inverse_direction);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    enter <= leave && leave >= 0.0
}

/// How a ray crosses a triangle.
enum Crossing {
    Miss,
    /// +1 if the ray leaves the solid, -1 if it enters.
    Through(i64),
    Unclear,
}

/// The crossing of a ray with a triangle (Möller, Trumbore 1997).
fn crossing(start: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Crossing {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let slope = direction.dot(normal);
    let scale = normal.length();
    if scale == 0.0 {
        return Crossing::Miss;
    }
    let to_start = start - a;
    if slope.abs() <= EDGE_TOLERANCE * scale {
        let is_near_plane = normal.dot(to_start).abs() <= 1e-6 * scale;
        return if is_near_plane { Crossing::Unclear } else { Crossing::Miss };
    }
    let turned = direction.cross(to_start);
    let (u, v, t) =
        (ac.dot(turned) / slope, -ab.dot(turned) / slope, -normal.dot(to_start) / slope);
    let inside = u.min(v).min(1.0 - u - v);
    if inside < -EDGE_TOLERANCE || t < 0.0 {
        Crossing::Miss
    } else if inside <= EDGE_TOLERANCE {
        Crossing::Unclear
    } else {
        Crossing::Through(if slope > 0.0 { 1 } else { -1 })
    }
}
