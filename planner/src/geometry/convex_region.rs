//! Convex regions of the horizontal plane: support polygons and regions of the centre of mass.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;

use crate::geometry::polygon::{HalfPlane, edges};

/// Most vertices of a region: two support polygons of 16 vertices.
pub const REGION_VERTICES_MAX: usize = 32;

/// Width of the grid (m) to which vertices are rounded, so that rounding errors make no thin
/// corners.
const GRID: f64 = 1e-9;

/// Depth (m) that [`ConvexRegion::nearest_inside`] adds to the requested one against rounding
/// errors.
const DEPTH_ROUNDING: f64 = 1e-12;

/// Rounds over all sides in which [`ConvexRegion::nearest_with_margin`] moves a point inward.
const PROJECTION_ROUNDS: usize = 8;

/// A convex polygon, counter-clockwise, in world x and y (m).
#[derive(Debug, Clone, Default)]
pub struct ConvexRegion {
    vertices: BoundedVec<DVec2, REGION_VERTICES_MAX>,
    /// The half plane of the side from each vertex to the next.
    sides: BoundedVec<HalfPlane, REGION_VERTICES_MAX>,
    centroid: DVec2,
}

impl ConvexRegion {
    /// The convex hull of points. Points beyond [`REGION_VERTICES_MAX`] are dropped, which only
    /// shrinks the region.
    pub fn hull(points: impl IntoIterator<Item = DVec2>) -> Self {
        let snapped =
            points.into_iter().take(REGION_VERTICES_MAX).map(|point| (point / GRID).round() * GRID);
        let mut sorted: BoundedVec<DVec2, REGION_VERTICES_MAX> = snapped.collect();
        sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let mut chain: BoundedVec<DVec2, { 2 * REGION_VERTICES_MAX }> = BoundedVec::new();
        half_hull(sorted.iter().copied(), &mut chain);
        chain.pop();
        half_hull(sorted.iter().rev().copied(), &mut chain);
        chain.pop();
        let vertices: BoundedVec<DVec2, REGION_VERTICES_MAX> =
            chain.into_iter().take(REGION_VERTICES_MAX).collect();
        let sides = edges(&vertices).map(|(a, b)| HalfPlane::left_of(a, b)).collect();
        let centroid = centroid(&vertices);
        Self { vertices, sides, centroid }
    }

    /// A polygon of the sole frame (m), projected onto world x and y.
    pub fn seen_from_above(world_from_sole: &Pose, polygon: &[DVec2]) -> Self {
        Self::hull(polygon.iter().map(|vertex| (*world_from_sole * vertex.extend(0.0)).truncate()))
    }

    /// The vertices, counter-clockwise.
    pub fn vertices(&self) -> &[DVec2] {
        &self.vertices
    }

    /// The half planes whose intersection is the region.
    pub(crate) fn sides(&self) -> &[HalfPlane] {
        &self.sides
    }

    /// Signed distance of a point to the border (m), positive inside; minus infinity for a
    /// degenerate region.
    pub fn margin(&self, point: DVec2) -> f64 {
        if self.sides.len() < 3 {
            return f64::NEG_INFINITY;
        }
        let inside = self.sides.iter().map(|side| side.depth(point)).fold(f64::INFINITY, f64::min);
        if inside >= 0.0 { inside } else { -self.nearest_on_border(point).distance(point) }
    }

    /// Whether a point lies at least `depth` (m, not negative) inside; never for a degenerate
    /// region.
    pub fn contains(&self, point: DVec2, depth: f64) -> bool {
        self.sides.len() >= 3 && self.sides.iter().all(|side| side.depth(point) >= depth)
    }

    /// The point of the region nearest to `point`.
    pub fn nearest(&self, point: DVec2) -> DVec2 {
        if self.contains(point, 0.0) { point } else { self.nearest_on_border(point) }
    }

    /// The centroid; the first vertex for a degenerate region.
    pub fn centroid(&self) -> DVec2 {
        self.centroid
    }

    /// The first point on the segment from `point` to the centroid that is at least `depth` (m, not
    /// negative) inside; the centroid if there is none.
    pub fn nearest_inside(&self, point: DVec2, depth: f64) -> DVec2 {
        if self.contains(point, depth) {
            return point;
        }
        let depth = depth + DEPTH_ROUNDING;
        let mut fraction: f64 = 0.0;
        for side in &self.sides {
            let (begin, end) = (side.depth(point), side.depth(self.centroid));
            if end <= depth {
                return self.centroid;
            }
            if begin < depth {
                fraction = fraction.max((depth - begin) / (end - begin));
            }
        }
        point + fraction * (self.centroid - point)
    }

    /// A point at least `depth` (m, not negative) inside, near `point`: it is moved inward from one
    /// side after the other, and where that does not suffice, toward the centroid.
    pub fn nearest_with_margin(&self, point: DVec2, depth: f64) -> DVec2 {
        let mut moved = point;
        for _ in 0..PROJECTION_ROUNDS {
            for side in &self.sides {
                moved += side.normal * (depth - side.depth(moved)).max(0.0);
            }
        }
        self.nearest_inside(moved, depth)
    }

    /// The nearest point of the sides that have `point` on their outer side; of all sides if there
    /// are none.
    fn nearest_on_border(&self, point: DVec2) -> DVec2 {
        let on_side = |(a, b): (DVec2, DVec2)| {
            let along = b - a;
            let length_squared = along.length_squared();
            let t = if length_squared > 0.0 {
                ((point - a).dot(along) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            a + t * along
        };
        let nearer = |a: DVec2, b: DVec2| {
            if b.distance_squared(point) < a.distance_squared(point) { b } else { a }
        };
        let facing =
            edges(&self.vertices).zip(&self.sides).filter(|(_, side)| side.depth(point) < 0.0);
        facing.map(|(edge, _)| on_side(edge)).reduce(nearer).unwrap_or_else(|| {
            let all = edges(&self.vertices).map(on_side);
            all.reduce(nearer).unwrap_or(point)
        })
    }
}

fn centroid(vertices: &[DVec2]) -> DVec2 {
    let origin = vertices.first().copied().unwrap_or_default();
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for (a, b) in edges(vertices) {
        let (a, b) = (a - origin, b - origin);
        let cross = a.perp_dot(b);
        area += cross;
        moment += (a + b) * cross;
    }
    if area.abs() < 1e-12 { origin } else { origin + moment / (3.0 * area) }
}

/// Appends the lower or upper half of a hull (Andrew's monotone chain) to `chain`.
fn half_hull<const N: usize>(
    points: impl Iterator<Item = DVec2>,
    chain: &mut BoundedVec<DVec2, N>,
) {
    let base = chain.len();
    for point in points {
        while chain.len() > base + 1 {
            let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
            if (b - a).perp_dot(point - b) > 1e-12 {
                break;
            }
            chain.pop();
        }
        if chain.push(point).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> ConvexRegion {
        let corners =
            [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
        ConvexRegion::hull(corners.map(DVec2::from))
    }

    #[test]
    fn the_hull_keeps_only_corners() {
        assert_eq!(
            square().vertices(),
            [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from)
        );
    }

    #[test]
    fn rounding_errors_lose_no_corner() {
        let x = 0.1 + 0.2;
        let corners = [(0.3, 1.0), (x, -1.0), (x, -0.5), (x, 0.5), (1.0, 1.0), (1.0, -1.0)];
        assert_eq!(ConvexRegion::hull(corners.map(DVec2::from)).vertices().len(), 4);
    }

    #[test]
    fn margin_is_signed() {
        assert!((square().margin(DVec2::new(0.5, 1.0)) - 0.5).abs() < 1e-12);
        assert!((square().margin(DVec2::new(5.0, 6.0)) + 5.0).abs() < 1e-12);
    }

    #[test]
    fn nearest_inside_has_its_depth() {
        let point = square().nearest_inside(DVec2::new(-3.0, 1.0), 0.25);
        assert!(square().margin(point) >= 0.25 && point.x < 0.25 + 1e-9);
        assert_eq!(square().nearest_inside(DVec2::new(-3.0, 1.0), 1.5), square().centroid());
    }

    #[test]
    fn nearest_is_on_the_border_for_points_outside() {
        for (point, nearest) in
            [((3.0, 1.0), (2.0, 1.0)), ((3.0, 4.0), (2.0, 2.0)), ((0.5, 0.25), (0.5, 0.25))]
        {
            assert!(square().nearest(DVec2::from(point)).distance(DVec2::from(nearest)) < 1e-12);
        }
    }

    #[test]
    fn containment_agrees_with_the_margin() {
        for index in 0..400 {
            let point =
                DVec2::new(0.15 * f64::from(index % 20) - 0.5, 0.15 * f64::from(index / 20) - 0.5);
            assert_eq!(square().contains(point, 0.1), square().margin(point) >= 0.1, "{point}");
        }
    }

    #[test]
    fn a_segment_is_degenerate() {
        let line = ConvexRegion::hull([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)].map(DVec2::from));
        assert_eq!(line.margin(DVec2::new(1.0, 0.0)), f64::NEG_INFINITY);
    }
}
