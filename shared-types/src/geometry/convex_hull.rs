//! Convex hulls of points in the plane and in space.

use glam::{DVec2, DVec3};

/// Most points of a hull that may include interior ones. Larger sets are reduced to the vertices of
/// the hull.
const HULL_POINTS_KEPT_MAX: usize = 256;
/// Smallest thickness of a point set that spans a volume, as a share of its longest extent.
const THICKNESS_RATIO_MIN: f64 = 1e-6;

/// The vertices of the convex hull of points in the plane, counter-clockwise, without collinear
/// ones (Andrew's monotone chain).
pub(crate) fn convex_polygon(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let mut lower = half_chain(sorted.iter().copied());
    let mut upper = half_chain(sorted.iter().rev().copied());
    lower.pop();
    upper.pop();
    lower.append(&mut upper);
    lower
}

fn half_chain(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut chain: Vec<DVec2> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..] {
            let cross = (b - a).perp_dot(point - b);
            if cross > 1e-12 * (b - a).length() * (point - b).length() {
                break;
            }
            chain.pop();
        }
        chain.push(point);
    }
    chain
}

/// The area of a counter-clockwise polygon.
pub(crate) fn polygon_area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// Points with the same convex hull: without duplicates, and without interior points if there are
/// more than [`HULL_POINTS_KEPT_MAX`].
///
/// # Errors
/// The points span no volume.
pub(crate) fn hull_points(mut points: Vec<DVec3>) -> Result<Vec<DVec3>, String> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    points.dedup();
    if !spans_volume(&points) {
        return Err("its points lie in one plane; a convex hull needs a volume".into());
    }
    if points.len() > HULL_POINTS_KEPT_MAX {
        points = hull_triangles(&points)?.0;
    }
    Ok(points)
}

/// Vertices and outward triangles of the convex hull of points that span a volume.
pub(crate) fn hull_triangles(points: &[DVec3]) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), String> {
    parry3d_f64::transformation::try_convex_hull(points)
        .map_err(|error| format!("has no convex hull: {error}"))
}

fn spans_volume(points: &[DVec3]) -> bool {
    let Some(&origin) = points.first() else { return false };
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().max_by(|a, b| measure(*a).total_cmp(&measure(*b))).unwrap_or(origin)
    };
    let along = farthest(&|p| (p - origin).length_squared()) - origin;
    let extent = along.length();
    if extent == 0.0 {
        return false;
    }
    let axis = along / extent;
    let side = farthest(&|p| (p - origin).reject_from_normalized(axis).length_squared());
    let side = (side - origin).reject_from_normalized(axis);
    if side.length() <= THICKNESS_RATIO_MIN * extent {
        return false;
    }
    let normal = axis.cross(side).normalize();
    points.iter().any(|p| normal.dot(*p - origin).abs() > THICKNESS_RATIO_MIN * extent)
}
