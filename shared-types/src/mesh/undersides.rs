//! The undersides of double-sided surfaces.
//!
//! Modelling programs export a sheet with every face twice, once for each side. The lower one is
//! no ground, and lies where the soles stand. Triangles block the way from both sides, so only the
//! upper one is needed.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DQuat, DVec2, DVec3};

/// Triangles whose unit normal rises or falls less than this are upright: they have no underside.
const SLOPE_MIN: f64 = 1e-9;
/// Planes whose normals and offsets (m) agree to this many parts are one.
const PLANE_PARTS: f64 = 1e7;
/// A triangle is covered if all but this share of its area is.
const UNCOVERED_MAX: f64 = 1e-6;
/// Most pairs of triangles in one plane that are compared.
const PAIRS_MAX: usize = 1 << 20;

/// Removes each triangle that faces down in the world and is wholly covered by triangles that lie
/// in its plane and face up.
pub(crate) fn remove_undersides(
    vertices: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
    world_from_mesh: DQuat,
) {
    let corners = |at: usize| triangles[at].map(|index| vertices[index as usize]);
    let mut is_underside = vec![false; triangles.len()];
    for Plane { up, upper, lower } in planes(triangles, vertices, world_from_mesh) {
        let axes = plane_axes(up);
        let twins: BTreeSet<[u32; 3]> = upper.iter().map(|at| sorted(triangles[*at])).collect();
        let is_small = upper.len().saturating_mul(lower.len()) <= PAIRS_MAX;
        for at in lower {
            let is_covered = || {
                let covers = upper.iter().map(|over| flat(corners(*over), axes));
                is_covered(flat(corners(at), axes), covers)
            };
            is_underside[at] = twins.contains(&sorted(triangles[at])) || (is_small && is_covered());
        }
    }
    let mut is_underside = is_underside.into_iter();
    triangles.retain(|_| is_underside.next() != Some(true));
}

/// The triangles of one plane, by the side that they show.
struct Plane {
    up: DVec3,
    upper: Vec<usize>,
    lower: Vec<usize>,
}

/// The planes that are no walls and hold triangles of both sides.
fn planes(triangles: &[[u32; 3]], vertices: &[DVec3], world_from_mesh: DQuat) -> Vec<Plane> {
    let mut planes: BTreeMap<[i64; 4], Plane> = BTreeMap::new();
    for (at, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|index| vertices[index as usize]);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let rise = (world_from_mesh * normal).z;
        if rise.abs() < SLOPE_MIN {
            continue;
        }
        let up = normal * rise.signum();
        let key = [up.x, up.y, up.z, up.dot(a)].map(|part| (part * PLANE_PARTS).round() as i64);
        let plane = planes.entry(key).or_insert(Plane { up, upper: vec![], lower: vec![] });
        if rise > 0.0 { plane.upper.push(at) } else { plane.lower.push(at) }
    }
    planes
        .into_values()
        .filter(|plane| !plane.upper.is_empty() && !plane.lower.is_empty())
        .collect()
}

fn sorted(mut triangle: [u32; 3]) -> [u32; 3] {
    triangle.sort_unstable();
    triangle
}

/// The two coordinates that show a plane best.
fn plane_axes(normal: DVec3) -> [usize; 2] {
    let steep = normal.abs();
    match (steep.x, steep.y, steep.z) {
        (x, y, z) if x >= y && x >= z => [1, 2],
        (_, y, z) if y >= z => [2, 0],
        _ => [0, 1],
    }
}

/// A triangle in a plane, counter-clockwise.
fn flat(corners: [DVec3; 3], [x, y]: [usize; 2]) -> [DVec2; 3] {
    let [a, b, c] = corners.map(|corner| DVec2::new(corner[x], corner[y]));
    if (b - a).perp_dot(c - a) < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// Whether triangles together cover another one.
fn is_covered(triangle: [DVec2; 3], covers: impl Iterator<Item = [DVec2; 3]>) -> bool {
    let whole = area(&triangle);
    let mut open = vec![triangle.to_vec()];
    for cover in covers {
        open = open.iter().flat_map(|part| outside(part, cover)).collect();
        open.retain(|part| area(part) > UNCOVERED_MAX * whole * 0.01);
        if open.is_empty() {
            return true;
        }
    }
    open.iter().map(|part| area(part)).sum::<f64>() <= UNCOVERED_MAX * whole
}

/// The convex parts of a convex polygon that lie outside a triangle.
fn outside(polygon: &[DVec2], [a, b, c]: [DVec2; 3]) -> Vec<Vec<DVec2>> {
    let mut parts = Vec::new();
    let mut inside = polygon.to_vec();
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let side = |point: DVec2| (to - from).perp_dot(point - from);
        parts.push(half(&inside, |point| -side(point)));
        inside = half(&inside, side);
        if inside.len() < 3 {
            return vec![polygon.to_vec()];
        }
    }
    parts.retain(|part| part.len() >= 3);
    parts
}

/// The part of a convex polygon where `side` is not negative.
fn half(polygon: &[DVec2], side: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (at, &point) in polygon.iter().enumerate() {
        let next = polygon[(at + 1) % polygon.len()];
        let (here, there) = (side(point), side(next));
        if here >= 0.0 {
            kept.push(point);
        }
        if here * there < 0.0 {
            kept.push(point + (next - point) * (here / (here - there)));
        }
    }
    kept
}

fn area(polygon: &[DVec2]) -> f64 {
    let (Some(&first), true) = (polygon.first(), polygon.len() >= 3) else { return 0.0 };
    polygon[1..].windows(2).map(|of| 0.5 * (of[0] - first).perp_dot(of[1] - first)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.0]];

    fn left(triangles: &[[u32; 3]], world_from_mesh: DQuat) -> Vec<[u32; 3]> {
        let mut left = triangles.to_vec();
        remove_undersides(&SQUARE.map(DVec3::from_array), &mut left, world_from_mesh);
        left
    }

    #[test]
    fn an_underside_is_removed_however_it_is_cut() {
        let upper = [[0, 1, 2], [0, 2, 3]];
        let fan = [[1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]];
        for lower in [&[[2, 1, 0], [3, 2, 0]][..], &[[1, 0, 3], [2, 1, 3]], &fan] {
            let both = [&upper, lower].concat();
            assert_eq!(left(&both, DQuat::IDENTITY), upper);
            // Turned over, the other side is the upper one.
            assert_eq!(left(&both, DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0)), lower);
            let upright = DQuat::from_xyzw(0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt());
            assert_eq!(left(&both, upright), both);
        }
    }

    #[test]
    fn a_side_that_is_not_wholly_covered_stays() {
        let half = [[0, 1, 2], [2, 1, 0], [3, 2, 0]];
        assert_eq!(left(&half, DQuat::IDENTITY), [[0, 1, 2], [3, 2, 0]]);
        // A cover that is there twice covers no more.
        let twice = [[0, 1, 4], [0, 1, 4], [1, 0, 2]];
        assert_eq!(left(&twice, DQuat::IDENTITY), twice);
    }
}
