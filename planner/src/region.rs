//! Convex regions of the ground plane: support polygons and where the centre of mass may be.

use glam::DVec2;
use heapless::Vec as BoundedVec;

/// Most vertices of a region: two support polygons of 16 vertices.
pub const REGION_VERTICES_MAX: usize = 32;

/// Points are snapped to a grid of this width (m), so that rounding errors make no needle-thin corners.
const GRID: f64 = 1e-9;

/// A convex polygon, counter-clockwise, in world x and y (m).
#[derive(Debug, Clone, Default)]
pub struct Region {
    vertices: BoundedVec<DVec2, REGION_VERTICES_MAX>,
}

impl Region {
    /// The convex hull of some points; those beyond [`REGION_VERTICES_MAX`] are left out, which only shrinks it.
    pub fn hull(points: impl IntoIterator<Item = DVec2>) -> Self {
        let snapped = points.into_iter().take(REGION_VERTICES_MAX).map(|point| (point / GRID).round() * GRID);
        let mut sorted: BoundedVec<DVec2, REGION_VERTICES_MAX> = snapped.collect();
        sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let mut chain: BoundedVec<DVec2, { 2 * REGION_VERTICES_MAX }> = BoundedVec::new();
        half_hull(sorted.iter().copied(), &mut chain);
        chain.pop();
        half_hull(sorted.iter().rev().copied(), &mut chain);
        chain.pop();
        Self { vertices: chain.into_iter().take(REGION_VERTICES_MAX).collect() }
    }

    /// The vertices, counter-clockwise.
    pub fn vertices(&self) -> &[DVec2] {
        &self.vertices
    }

    /// The signed distance of a point to the border, positive inside; minus infinity for a degenerate region.
    pub fn margin(&self, point: DVec2) -> f64 {
        if self.vertices.len() < 3 {
            return f64::NEG_INFINITY;
        }
        let inside = self.edges().map(|(a, b)| (b - a).normalize_or_zero().perp_dot(point - a)).fold(f64::INFINITY, f64::min);
        if inside >= 0.0 { inside } else { -self.nearest_on_border(point).distance(point) }
    }

    /// The point of the region that is nearest to `point`.
    pub fn nearest(&self, point: DVec2) -> DVec2 {
        if self.margin(point) >= 0.0 { point } else { self.nearest_on_border(point) }
    }

    /// The centroid.
    pub fn centroid(&self) -> DVec2 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let (mut area, mut moment) = (0.0, DVec2::ZERO);
        for (a, b) in self.edges() {
            let (a, b) = (a - origin, b - origin);
            let cross = a.perp_dot(b);
            area += cross;
            moment += (a + b) * cross;
        }
        if area.abs() < 1e-12 { origin } else { origin + moment / (3.0 * area) }
    }

    /// The point nearest to `point` that is at least `depth` inside, or the centroid where the region is too small.
    pub fn nearest_inside(&self, point: DVec2, depth: f64) -> DVec2 {
        if self.margin(point) >= depth {
            return point;
        }
        let centroid = self.centroid();
        let (mut outside, mut inside) = (0.0, 1.0);
        for _ in 0..24 {
            let middle = 0.5 * (outside + inside);
            if self.margin(point + middle * (centroid - point)) >= depth { inside = middle } else { outside = middle }
        }
        point + inside * (centroid - point)
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(a, b)| (*a, *b))
    }

    fn nearest_on_border(&self, point: DVec2) -> DVec2 {
        let on_edge = |(a, b): (DVec2, DVec2)| {
            let along = b - a;
            let length_squared = along.length_squared();
            let t = if length_squared > 0.0 { ((point - a).dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
            a + t * along
        };
        let nearer = |a: DVec2, b: DVec2| if b.distance_squared(point) < a.distance_squared(point) { b } else { a };
        self.edges().map(on_edge).reduce(nearer).unwrap_or(point)
    }
}

/// Appends one side of the hull (Andrew's monotone chain) behind what `chain` holds.
fn half_hull<const N: usize>(points: impl Iterator<Item = DVec2>, chain: &mut BoundedVec<DVec2, N>) {
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

    fn square() -> Region {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
        Region::hull(corners.map(DVec2::from))
    }

    #[test]
    fn hull_keeps_the_corners_only() {
        assert_eq!(square().vertices(), [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from));
    }

    #[test]
    fn rounding_errors_lose_no_corner() {
        let x = 0.1 + 0.2;
        let corners = [(0.3, 1.0), (x, -1.0), (x, -0.5), (x, 0.5), (1.0, 1.0), (1.0, -1.0)];
        assert_eq!(Region::hull(corners.map(DVec2::from)).vertices().len(), 4);
    }

    #[test]
    fn margin_is_signed() {
        assert!((square().margin(DVec2::new(0.5, 1.0)) - 0.5).abs() < 1e-12);
        assert!((square().margin(DVec2::new(5.0, 6.0)) + 5.0).abs() < 1e-12);
    }

    #[test]
    fn nearest_inside_keeps_its_depth() {
        let point = square().nearest_inside(DVec2::new(-3.0, 1.0), 0.25);
        assert!(square().margin(point) >= 0.25 && point.x < 0.26);
    }

    #[test]
    fn a_line_is_no_region() {
        let line = Region::hull([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)].map(DVec2::from));
        assert_eq!(line.margin(DVec2::new(1.0, 0.0)), f64::NEG_INFINITY);
    }
}
