//! Convex polygons in a plane, counter-clockwise.

use glam::DVec2;

use crate::base::comparison::smallest;

/// Twice the area (m2) below which three points count as on one line.
const COLLINEAR_AREA: f64 = 1e-11;

/// The convex hull's vertices, counter-clockwise, without points on its sides; fewer than three
/// where there is no area.
pub fn hull(points: &[DVec2]) -> Vec<DVec2> {
    hull_indices(points).into_iter().map(|index| points[index]).collect()
}

/// As [`hull`], as indices into `points` (Andrew's monotone chain).
pub fn hull_indices(points: &[DVec2]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        points[a].x.total_cmp(&points[b].x).then(points[a].y.total_cmp(&points[b].y))
    });
    let mut lower = half_hull(points, order.iter().copied());
    let mut upper = half_hull(points, order.iter().rev().copied());
    lower.pop();
    upper.pop();
    lower.extend(upper);
    without_flat_corners(points, lower)
}

fn half_hull(points: &[DVec2], order: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut chain: Vec<usize> = Vec::new();
    for index in order {
        while let [.., a, b] = chain[..] {
            if turn(points, [a, b, index]) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(index);
    }
    chain
}

/// Only once the hull is closed may a corner go for being nearly flat: along the way, two points
/// above each other whose order rounding decides would take a true corner with them.
fn without_flat_corners(points: &[DVec2], mut outline: Vec<usize>) -> Vec<usize> {
    let mut index = 0;
    while index < outline.len() && outline.len() >= 3 {
        let count = outline.len();
        if turn(
            points,
            [outline[(index + count - 1) % count], outline[index], outline[(index + 1) % count]],
        ) <= COLLINEAR_AREA
        {
            outline.remove(index);
            index = index.saturating_sub(1);
        } else {
            index += 1;
        }
    }
    outline
}

/// Twice the area of a triangle, m2; positive if counter-clockwise.
fn turn(points: &[DVec2], [a, b, c]: [usize; 3]) -> f64 {
    (points[b] - points[a]).perp_dot(points[c] - points[b])
}

/// The area, m2.
pub fn area(polygon: &[DVec2]) -> f64 {
    0.5 * sides(polygon).map(|(a, b)| a.perp_dot(b)).sum::<f64>()
}

/// The signed distance of a point to the boundary: positive inside, minus infinity if the polygon
/// has no area, NaN if a coordinate is NaN.
pub fn margin(polygon: &[DVec2], point: DVec2) -> f64 {
    if polygon.len() < 3 {
        return f64::NEG_INFINITY;
    }
    let inside =
        smallest(sides(polygon).map(|(a, b)| (b - a).normalize_or_zero().perp_dot(point - a)));
    if inside >= 0.0 {
        return inside;
    }
    -smallest(sides(polygon).map(|(a, b)| distance_to_segment(a, b, point)))
}

/// The part of a convex polygon with `direction . point <= reach`; none if `reach` is NaN.
pub fn clip(polygon: &[DVec2], direction: DVec2, reach: f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in sides(polygon) {
        let (before, after) = (reach - direction.dot(a), reach - direction.dot(b));
        if before >= 0.0 {
            kept.push(a);
        }
        if before >= 0.0 && after < 0.0 || before < 0.0 && after >= 0.0 {
            kept.push(a + (b - a) * (before / (before - after)));
        }
    }
    kept
}

/// The sides, each from a vertex to the next.
pub fn sides(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

/// At most `count` (four or more) of a convex polygon's vertices, in order: a polygon inside this
/// one. To those furthest along the axes come those furthest beyond its sides, one after the other.
pub fn outermost_vertices(polygon: &[DVec2], count: usize) -> Vec<usize> {
    if polygon.len() <= count {
        return (0..polygon.len()).collect();
    }
    let furthest = |along: DVec2| {
        (0..polygon.len()).fold(0, |best, i| {
            if polygon[i].dot(along) > polygon[best].dot(along) { i } else { best }
        })
    };
    let mut kept: Vec<usize> = (0..4).map(|k| furthest(direction(k, 4))).collect();
    kept.sort_unstable();
    kept.dedup();
    while kept.len() < count {
        let Some(beyond) = furthest_beyond(polygon, &kept) else { break };
        kept.insert(kept.partition_point(|&index| index < beyond), beyond);
    }
    kept
}

/// The vertex of a convex polygon that is furthest beyond the sides between some of its vertices.
fn furthest_beyond(polygon: &[DVec2], kept: &[usize]) -> Option<usize> {
    let mut best = (0.0, None);
    for (place, &first) in kept.iter().enumerate() {
        let last = kept.get(place + 1).copied().unwrap_or(kept[0] + polygon.len());
        let (a, b) = (polygon[first], polygon[last % polygon.len()]);
        let along = (b - a).normalize_or_zero();
        for index in (first + 1..last).map(|index| index % polygon.len()) {
            let beyond = -along.perp_dot(polygon[index] - a);
            if beyond > best.0 {
                best = (beyond, Some(index));
            }
        }
    }
    best.1
}

/// The `k`-th of `count` evenly spaced unit vectors.
pub fn direction(k: usize, count: usize) -> DVec2 {
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / count as f64);
    DVec2::new(cos, sin)
}

fn distance_to_segment(a: DVec2, b: DVec2, point: DVec2) -> f64 {
    let along = b - a;
    let t = if along.length_squared() > 0.0 {
        ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + t * along).distance(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::randoms;

    fn square() -> Vec<DVec2> {
        hull(
            &[(0., 0.), (1., 0.), (0.5, 0.0), (1., 1.), (0., 1.), (0.4, 0.6), (1.0, 0.3)]
                .map(DVec2::from),
        )
    }

    #[test]
    fn hull_keeps_corners_only() {
        assert_eq!(square(), [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from));
        assert!((area(&square()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rounding_takes_no_corner() {
        // Left and right side are upright but for the last digits; the rightmost point is the lower
        // one.
        let points = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0 + 1e-12, 1.0), (1.0 + 2e-12, 0.0)]
            .map(DVec2::from);
        assert!((area(&hull(&points)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn corners_that_are_flat_but_for_rounding_are_left_out() {
        let bulges = [(0.5, -1e-13), (1.0 + 1e-13, 0.5), (0.5, 1.0 + 1e-13), (-1e-13, 0.5)];
        let points: Vec<DVec2> = square().into_iter().chain(bulges.map(DVec2::from)).collect();
        assert_eq!(hull(&points), square());
    }

    #[test]
    fn margin_is_signed_and_exact_past_a_corner() {
        assert!((margin(&square(), DVec2::new(0.5, 0.2)) - 0.2).abs() < 1e-12);
        assert!((margin(&square(), DVec2::new(-3.0, -4.0)) + 5.0).abs() < 1e-12);
        assert_eq!(margin(&square()[..2], DVec2::ZERO), f64::NEG_INFINITY);
    }

    #[test]
    fn nan_is_inside_nothing() {
        for point in [DVec2::new(f64::NAN, 0.5), DVec2::new(0.5, f64::NAN), DVec2::NAN] {
            let margin = margin(&square(), point);
            assert!(margin.is_nan(), "{point}: {margin}");
        }
        let mut polygon = square();
        polygon[2].x = f64::NAN;
        assert!(margin(&polygon, DVec2::new(0.5, 0.5)).is_nan());
    }

    #[test]
    fn points_on_a_line_have_no_area() {
        let line: Vec<DVec2> =
            (0..9).map(|i| DVec2::new(0.1 * f64::from(i), 0.3 * f64::from(i))).collect();
        assert!(hull(&line).len() < 3);
    }

    #[test]
    fn the_margin_is_the_distance_to_the_nearest_point_of_the_boundary() {
        let mut random = randoms(9);
        for _ in 0..40 {
            let cloud: Vec<DVec2> =
                (0..9).map(|_| DVec2::new(random(-1.0, 1.0), random(-1.0, 1.0))).collect();
            let outline = hull(&cloud);
            let boundary: Vec<DVec2> = sides(&outline)
                .flat_map(|(a, b)| (0..=500).map(move |k| a.lerp(b, f64::from(k) / 500.0)))
                .collect();
            for _ in 0..20 {
                let at = DVec2::new(random(-1.5, 1.5), random(-1.5, 1.5));
                let nearest = boundary.iter().map(|on| on.distance(at)).fold(f64::MAX, f64::min);
                let is_inside = sides(&outline).all(|(a, b)| (b - a).perp_dot(at - a) >= 0.0);
                let expected = if is_inside { nearest } else { -nearest };
                let found = margin(&outline, at);
                assert!((found - expected).abs() < 5e-3, "{found} {expected}");
                assert!(found.abs() <= nearest + 1e-12);
            }
        }
        // The nearest point may be a corner, and a side may have no length.
        let square = [(0., 0.), (1., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from);
        assert_eq!(margin(&square, DVec2::new(4.0, 5.0)), -5.0);
        assert_eq!(margin(&square, DVec2::new(0.5, -2.0)), -2.0);
    }

    #[test]
    fn the_outermost_vertices_leave_little_of_a_polygon_outside() {
        let circle: Vec<DVec2> = (0..64).map(|k| direction(k, 64)).collect();
        let beyond = |polygon: &[DVec2], count: usize| {
            let kept = outermost_vertices(polygon, count);
            assert!(kept.len() <= count && kept.is_sorted());
            let inner: Vec<DVec2> = kept.iter().map(|&index| polygon[index]).collect();
            polygon.iter().map(|at| -margin(&inner, *at)).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!(
            (beyond(&circle, 8) - (1.0 - libm::cos(0.125 * std::f64::consts::PI))).abs() < 1e-9
        );
        assert_eq!(outermost_vertices(&circle[..5], 8), [0, 1, 2, 3, 4]);
        // A sole with a round heel, cut off along a line from the middle of its side on: the corner
        // there is furthest in none of sixteen even directions.
        let corners = [(0.05, -0.04), (0.14, -0.013), (0.12, 0.04)].map(DVec2::from);
        let heel = (20..=60).map(|k| DVec2::new(-0.06, 0.0) + 0.0401 * direction(k, 80));
        let sole = hull(&heel.chain(corners).collect::<Vec<_>>());
        assert!(beyond(&sole, 16) < 1e-3, "{}", beyond(&sole, 16));
    }
}
