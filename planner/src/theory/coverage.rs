//! Lemma 3: which radius the discs about the vertices of a route need to cover all footholds of a
//! solution [Grey 5.5].

use glam::DVec2;

/// Equation 5.7: h_m, an upper bound of the distance (m) of any placement in any of the cylinders
/// of this radius (m) about `placements` from a path through `path`, all seen from above. The
/// bound is exact where a placement's cylinder lies beside the path.
///
/// # Panics
/// The path has no point.
pub fn placement_distance(placements: &[DVec2], cylinder_radius: f64, path: &[DVec2]) -> f64 {
    let farthest = placements.iter().map(|&placement| path_distance(placement, path));
    farthest.fold(0.0, f64::max) + cylinder_radius
}

/// Distance of a point from a path through some points, m.
///
/// # Panics
/// The path has no point.
pub fn path_distance(point: DVec2, path: &[DVec2]) -> f64 {
    assert!(!path.is_empty(), "a path has a point");
    let to_vertex = path.iter().map(|vertex| vertex.distance(point)).fold(f64::INFINITY, f64::min);
    let to_segment = |ends: &[DVec2]| {
        let along = ends[1] - ends[0];
        let share = (point - ends[0]).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (ends[0] + share.clamp(0.0, 1.0) * along).distance(point)
    };
    path.windows(2).map(to_segment).fold(to_vertex, f64::min)
}

/// Lemma 3 as printed: the least radius (m) of the discs, with balls of at most a quarter of it.
/// It holds, and is stricter than needed.
pub fn disc_radius_printed(placement_distance: f64) -> f64 {
    2.0 * placement_distance
}

/// The least radius (m) of the discs by the triangle inequality, for balls of radius `ball_radius`
/// (m): a sample lies within it of a point p_i of the path, and the nearest p_i, as they stand
/// `ball_radius` apart, within half of it of any point of the path.
pub fn disc_radius_min(placement_distance: f64, ball_radius: f64) -> f64 {
    placement_distance + 1.5 * ball_radius
}
