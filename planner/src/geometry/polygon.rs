//! Convex polygons: clipping, hulls, areas. Vertices are in counter-clockwise order.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

/// Most vertices of a face; larger outlines are split, or approximated from inside.
pub(crate) const FACE_VERTICES_MAX: usize = 64;
/// Most vertices of a face while it is clipped: its own and one for every clip plane.
pub(crate) const CLIP_VERTICES_MAX: usize = FACE_VERTICES_MAX + 24;

/// A polygon that is clipped, and a spare buffer; both hold [`CLIP_VERTICES_MAX`] vertices without
/// growing.
#[derive(Debug)]
pub(crate) struct ClipBuffer {
    /// The polygon.
    pub(crate) polygon: Vec<DVec3>,
    /// The result of the next clip.
    pub(crate) spare: Vec<DVec3>,
}

impl ClipBuffer {
    /// Two empty buffers.
    pub(crate) fn new() -> Self {
        Self {
            polygon: Vec::with_capacity(CLIP_VERTICES_MAX),
            spare: Vec::with_capacity(CLIP_VERTICES_MAX),
        }
    }
}

/// The outward unit normals of a convex polygon's sides with their offsets.
pub(crate) fn outward_sides(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, f64)> + Clone + '_ {
    edges(polygon).filter(|(a, b)| a.distance_squared(*b) > 0.0).map(|(a, b)| {
        let normal = -inward_normal(a, b);
        (normal, normal.dot(a))
    })
}

/// Clips a planar convex polygon to the points where `keep`, an affine function, is not negative.
pub(crate) fn clip(polygon: &mut Vec<DVec3>, spare: &mut Vec<DVec3>, keep: impl Fn(DVec3) -> f64) {
    spare.clear();
    let Some(&last) = polygon.last() else { return };
    let (mut a, mut a_keep) = (last, keep(last));
    for &b in polygon.iter() {
        let b_keep = keep(b);
        if (a_keep >= 0.0) != (b_keep >= 0.0) {
            push(spare, a + (b - a) * (a_keep / (a_keep - b_keep)));
        }
        if b_keep >= 0.0 {
            push(spare, b);
        }
        (a, a_keep) = (b, b_keep);
    }
    std::mem::swap(polygon, spare);
}

/// Appends a point. Buffers hold a face's vertices and one for every clip plane, so no point is
/// dropped; a dropped point would shrink the polygon.
fn push(points: &mut Vec<DVec3>, point: DVec3) {
    debug_assert!(points.len() < CLIP_VERTICES_MAX, "the clip buffer is full");
    if points.len() < CLIP_VERTICES_MAX {
        points.push(point);
    }
}

/// The points with `normal . p >= offset`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfPlane {
    /// Inward normal, usually of length 1.
    pub(crate) normal: DVec2,
    /// `normal . p` of the points on the border.
    pub(crate) offset: f64,
}

impl HalfPlane {
    /// The half plane to the left of the line from `a` to `b`.
    pub(crate) fn left_of(a: DVec2, b: DVec2) -> Self {
        let normal = inward_normal(a, b);
        Self { normal, offset: normal.dot(a) }
    }

    /// `normal . point - offset`: for a normal of length 1 the distance to the border, positive
    /// inside.
    pub(crate) fn depth(&self, point: DVec2) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// The part of a convex polygon in a half plane. A corner that finds no memory is left out.
pub(crate) fn clipped_to<const N: usize>(
    polygon: &heapless::Vec<DVec2, N>,
    half_plane: &HalfPlane,
) -> heapless::Vec<DVec2, N> {
    let mut kept = heapless::Vec::new();
    let mut before = polygon.last().copied();
    for point in polygon {
        let a = before.as_ref().map_or(0.0, |before| half_plane.depth(*before));
        let b = half_plane.depth(*point);
        if let Some(before) = before.filter(|_| (a < 0.0) != (b < 0.0)) {
            let _ = kept.push(before.lerp(*point, a / (a - b)));
        }
        if b >= 0.0 {
            let _ = kept.push(*point);
        }
        before = Some(*point);
    }
    kept
}

/// The half planes whose intersection is a convex polygon.
pub(crate) type Sides = heapless::Vec<HalfPlane, POLYGON_VERTICES_MAX>;

/// The sides of a polygon of at most `POLYGON_VERTICES_MAX` vertices.
pub(crate) fn sides_of(outline: &[DVec2]) -> Sides {
    edges(outline).take(POLYGON_VERTICES_MAX).map(|(a, b)| HalfPlane::left_of(a, b)).collect()
}

/// Clips a polygon in the sole frame to the vertical prism over an outline, moved inward by `inset`
/// (m).
pub(crate) fn clip_to_sides(buffer: &mut ClipBuffer, sides: &[HalfPlane], inset: f64) {
    for HalfPlane { normal, offset } in sides {
        let offset = offset + inset;
        if buffer.polygon.iter().any(|p| normal.dot(p.truncate()) < offset) {
            clip(&mut buffer.polygon, &mut buffer.spare, |p| normal.dot(p.truncate()) - offset);
        }
    }
}

/// The sides of a polygon, as pairs of vertices.
pub(crate) fn edges(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + Clone + '_ {
    (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
}

/// The unit normal of a side that points into a counter-clockwise polygon; zero for a side of
/// length 0.
pub(crate) fn inward_normal(a: DVec2, b: DVec2) -> DVec2 {
    (b - a).perp().normalize_or_zero()
}

/// Twice the signed area of the triangle `a b c`.
pub(crate) fn cross(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Twice the vector area of a flat convex polygon, along its normal.
pub(crate) fn spanned(corners: &[DVec3]) -> DVec3 {
    corners.windows(2).map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0])).sum()
}

/// Sorts `points` and writes their convex hull, counter-clockwise, to `hull`.
/// `hull` does not grow if its capacity is `points.len() + 8`.
pub(crate) fn convex_hull(points: &mut [DVec2], hull: &mut Vec<DVec2>) {
    hull.clear();
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let count = points.len();
    let both_chains = (0..count).chain((0..count.saturating_sub(1)).rev());
    let mut chain_start = 1;
    for (step, i) in both_chains.enumerate() {
        if step == count {
            chain_start = hull.len();
        }
        while hull.len() > chain_start
            && cross(hull[hull.len() - 2], hull[hull.len() - 1], points[i]) <= 0.0
        {
            hull.pop();
        }
        hull.push(points[i]);
    }
    if hull.len() > 1 {
        hull.pop();
    }
}

/// Twice the area (m2) up to which a vertex is removed.
const CORNER_AREA_MIN: f64 = 1e-10;

/// Removes vertices of negligible area, and further ones until at most `vertices_max` are left,
/// each time the one of least area. The polygon only shrinks.
pub(crate) fn simplify(hull: &mut Vec<DVec2>, vertices_max: usize) {
    while hull.len() > 2 {
        let (cheapest, cost) = cheapest_corner(hull);
        if hull.len() <= vertices_max && cost > CORNER_AREA_MIN {
            break;
        }
        hull.remove(cheapest);
    }
}

/// The corner of a convex polygon without which least is lost, and twice the area of that, m2.
pub(crate) fn cheapest_corner(hull: &[DVec2]) -> (usize, f64) {
    let n = hull.len();
    let cost = |i: usize| cross(hull[(i + n - 1) % n], hull[i], hull[(i + 1) % n]);
    let costs = (0..n).map(|i| (i, cost(i)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

/// The area and the centroid of a convex polygon; `(0, first vertex or origin)` for one without
/// interior.
pub(crate) fn area_and_centroid(polygon: &[DVec2]) -> (f64, DVec2) {
    let Some(&origin) = polygon.first() else { return (0.0, DVec2::ZERO) };
    let (mut doubled, mut moment) = (0.0, DVec2::ZERO);
    for (a, b) in edges(polygon) {
        let weight = (a - origin).perp_dot(b - origin);
        doubled += weight;
        moment += weight * ((a - origin) + (b - origin));
    }
    if doubled <= 0.0 { (0.0, origin) } else { (0.5 * doubled, origin + moment / (3.0 * doubled)) }
}

/// The greatest distance between two points of a convex polygon, m.
pub(crate) fn diameter(polygon: &[DVec2]) -> f64 {
    let distances = polygon.iter().flat_map(|a| polygon.iter().map(|b| a.distance(*b)));
    distances.fold(0.0, f64::max)
}

/// The distance from a point to the nearest side, negative outside.
pub(crate) fn inner_distance(polygon: &[DVec2], point: DVec2) -> f64 {
    edges(polygon).map(|(a, b)| inward_normal(a, b).dot(point - a)).fold(f64::INFINITY, f64::min)
}

/// The distance from a point to a convex polygon, 0 inside; two corners are a line, one a point.
pub(crate) fn distance_to(polygon: &[DVec2], point: DVec2) -> f64 {
    if polygon.len() > 2 && inner_distance(polygon, point) >= 0.0 {
        return 0.0;
    }
    edges(polygon)
        .map(|(a, b)| (closest_on_segment(a, b, point) - point).length())
        .fold(f64::INFINITY, f64::min)
}

/// The point of the segment `a b` nearest to `point`.
pub(crate) fn closest_on_segment(a: DVec2, b: DVec2, point: DVec2) -> DVec2 {
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared < 1e-24 {
        a
    } else {
        a + along * ((point - a).dot(along) / length_squared).clamp(0.0, 1.0)
    }
}

/// Least width of a convex counter-clockwise polygon, m; infinite where that has no side.
pub(crate) fn least_width(polygon: &[DVec2]) -> f64 {
    least_width_of(polygon.iter().copied())
}

/// Least width of a convex counter-clockwise polygon projected onto x and y, m; 0 where that has no
/// side.
pub(crate) fn width(polygon: &[DVec3]) -> f64 {
    let least = least_width_of(polygon.iter().map(|corner| corner.truncate()));
    if least.is_finite() { least } else { 0.0 }
}

/// The least, over the sides of a polygon, of the distance of the corner farthest from it, m.
fn least_width_of(corners: impl Iterator<Item = DVec2> + Clone) -> f64 {
    let next = corners.clone().cycle().skip(1);
    let sides = corners.clone().zip(next).filter(|(a, b)| a.distance_squared(*b) > 0.0);
    let across = sides.map(|(a, b)| {
        let normal = -inward_normal(a, b);
        let offset = normal.dot(a);
        corners.clone().map(|corner| offset - normal.dot(corner)).fold(0.0, f64::max)
    });
    across.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec2> {
        vec![DVec2::new(0.0, 0.0), DVec2::new(2.0, 0.0), DVec2::new(2.0, 1.0), DVec2::new(0.0, 1.0)]
    }

    #[test]
    fn the_hull_of_a_filled_square_is_its_corners() {
        let mut points = square();
        points.extend([
            DVec2::new(1.0, 0.0),
            DVec2::new(1.0, 0.5),
            DVec2::new(0.0, 0.0),
            DVec2::new(2.0, 0.5),
        ]);
        let mut hull = Vec::new();
        convex_hull(&mut points, &mut hull);
        assert_eq!(hull, square());
    }

    #[test]
    fn the_hull_of_few_points_has_no_area() {
        for points in [
            vec![],
            vec![DVec2::ONE],
            vec![DVec2::ONE; 3],
            vec![DVec2::ZERO, DVec2::ONE, 0.5 * DVec2::ONE],
        ] {
            let mut hull = Vec::new();
            convex_hull(&mut points.clone(), &mut hull);
            assert!(area_and_centroid(&hull).0 == 0.0, "{points:?} gave {hull:?}");
        }
    }

    #[test]
    fn areas_centroids_and_distances() {
        let (area, centroid) = area_and_centroid(&square());
        assert_eq!((area, centroid), (2.0, DVec2::new(1.0, 0.5)));
        assert_eq!(inner_distance(&square(), centroid), 0.5);
        assert_eq!(distance_to(&square(), centroid), 0.0);
        assert_eq!(distance_to(&square(), DVec2::new(5.0, 5.0)), 5.0);
    }

    #[test]
    fn simplify_removes_the_smallest_corner_first() {
        let mut hull = square();
        hull.insert(1, DVec2::new(1.0, -0.001));
        simplify(&mut hull, 4);
        assert_eq!(hull, square());
    }

    #[test]
    fn rounding_errors_on_a_vertical_side_keep_the_corners() {
        let noisy =
            [(0.0, 0.0), (1e-17, 1.0), (2e-17, 0.5), (2.0, 0.0), (2.0 + 4e-16, 0.7), (2.0, 1.0)];
        let mut hull = Vec::new();
        convex_hull(&mut noisy.map(DVec2::from), &mut hull);
        simplify(&mut hull, 16);
        assert_eq!(hull.len(), 4, "{hull:?}");
        assert!((area_and_centroid(&hull).0 - 2.0).abs() < 1e-12);
    }
}
