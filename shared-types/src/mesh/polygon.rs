//! Cuts faces of more than three corners into triangles, concave ones included.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::DVec3;

/// Triangles that differ from their polygon by more than this share of its area show that its
/// outline crosses itself.
const AREA_ERROR_MAX: f64 = 1e-6;
/// Corners nearer to one line than this share of their extent enclose no area.
const COLLINEAR_RATIO: f64 = 1e-12;

/// Buffers for cutting polygons.
#[derive(Default)]
pub(crate) struct Polygons {
    earcut: Earcut<f64>,
    points: Vec<[f64; 3]>,
    plane: Vec<[f64; 2]>,
    indices: Vec<u32>,
}

/// The triangles of a polygon.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PolygonTriangles {
    /// Indices of the polygon's corners, wound as the polygon is.
    pub(crate) triangles: Vec<[usize; 3]>,
    /// How far the corners lie off one plane; infinite where the outline crosses itself.
    pub(crate) off_plane: f64,
}

impl Polygons {
    /// Cuts a polygon. The triangles do not depend on the corner that is named first, nor, but for
    /// their winding, on the polygon's. A polygon without area has none. One that crosses itself
    /// becomes a fan, which has at least its corners.
    pub(crate) fn cut(&mut self, corners: &[DVec3]) -> PolygonTriangles {
        let (ring, is_reversed) = distinct_corners(corners);
        let points: Vec<DVec3> = ring.iter().map(|at| corners[*at]).collect();
        if are_collinear(&points) {
            return PolygonTriangles { triangles: Vec::new(), off_plane: 0.0 };
        }
        let (triangles, off_plane) = match self.triangulate(&points) {
            Some(triangles) => (triangles, off_plane(&points)),
            None => ((2..ring.len()).map(|at| [0, at - 1, at]).collect(), f64::INFINITY),
        };
        let wound = |[a, b, c]: [usize; 3]| if is_reversed { [a, c, b] } else { [a, b, c] };
        let named = |triangle: [usize; 3]| wound(triangle.map(|at| ring[at]));
        PolygonTriangles { triangles: triangles.into_iter().map(named).collect(), off_plane }
    }

    /// Triangles that together have the area of a polygon; `None` where there are none.
    fn triangulate(&mut self, points: &[DVec3]) -> Option<Vec<[usize; 3]>> {
        let Self { earcut, points: buffer, plane, indices } = self;
        // Far from the origin the normal would lose its digits.
        buffer.clear();
        buffer.extend(points.iter().map(|point| (*point - points[0]).to_array()));
        if !project3d_to_2d(buffer, buffer.len(), plane) {
            return None;
        }
        earcut.earcut(plane.iter().copied(), &[], indices);
        let error = earcut::deviation(plane.iter().copied(), &[], indices);
        let is_whole = error <= AREA_ERROR_MAX && !indices.is_empty();
        is_whole.then(|| {
            indices.chunks_exact(3).map(|of| [0, 1, 2].map(|at| of[at] as usize)).collect()
        })
    }
}

/// The corners, without one that repeats the one before it, from the first in the order of
/// coordinates towards the first of its two neighbours; and whether this is against the polygon's
/// winding.
fn distinct_corners(corners: &[DVec3]) -> (Vec<usize>, bool) {
    let before = |at: usize| corners[(at + corners.len() - 1) % corners.len()];
    let mut ring: Vec<usize> =
        (0..corners.len()).filter(|at| corners[*at] != before(*at)).collect();
    let order = |a: &usize, b: &usize| {
        let [a, b] = [a, b].map(|at| corners[*at]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    };
    let Some(first) = (0..ring.len()).min_by(|a, b| order(&ring[*a], &ring[*b])) else {
        return (ring, false);
    };
    ring.rotate_left(first);
    let is_reversed = ring.len() > 2 && order(&ring[1], &ring[ring.len() - 1]).is_gt();
    if is_reversed {
        ring[1..].reverse();
    }
    (ring, is_reversed)
}

/// Whether all corners lie on one line.
fn are_collinear(points: &[DVec3]) -> bool {
    let Some(&origin) = points.first() else { return true };
    let along = points
        .iter()
        .map(|point| *point - origin)
        .fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let extent = along.length_squared();
    let is_near_line =
        |point: &DVec3| along.cross(*point - origin).length() <= COLLINEAR_RATIO * extent;
    points.iter().all(is_near_line)
}

/// The largest distance of a corner from the plane through the corners' mean along the polygon's
/// area.
fn off_plane(points: &[DVec3]) -> f64 {
    let origin = points[0];
    let mean = points.iter().map(|point| *point - origin).sum::<DVec3>() / points.len() as f64;
    let next = points.iter().cycle().skip(1);
    let area: DVec3 = points.iter().zip(next).map(|(a, b)| (*a - origin).cross(*b - origin)).sum();
    let Some(normal) = area.try_normalize() else { return f64::INFINITY };
    points.iter().map(|point| normal.dot(*point - origin - mean).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(outline: &[[f64; 3]]) -> PolygonTriangles {
        Polygons::default()
            .cut(&outline.iter().map(|at| DVec3::from_array(*at)).collect::<Vec<_>>())
    }

    fn area(outline: &[[f64; 3]], cut: &PolygonTriangles) -> DVec3 {
        let corner = |at: usize| DVec3::from_array(outline[at]);
        let areas = cut.triangles.iter().map(|of| of.map(corner));
        areas.map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum()
    }

    const NOTCHED: [[f64; 3]; 5] =
        [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [1.0, 0.5, 1.0], [0.0, 2.0, 1.0]];

    #[test]
    fn a_concave_polygon_keeps_its_area_and_side_from_whichever_corner_and_side_it_is_named() {
        let places = |outline: &[[f64; 3]]| {
            let cut = cut(outline);
            let mut triangles: Vec<Vec<String>> = cut
                .triangles
                .iter()
                .map(|of| {
                    let mut corners: Vec<_> = of.map(|at| format!("{:?}", outline[at])).to_vec();
                    corners.sort();
                    corners
                })
                .collect();
            triangles.sort();
            (triangles, area(outline, &cut))
        };
        let (triangles, area) = places(&NOTCHED);
        assert!((area - DVec3::Z * 2.5).length() < 1e-12, "{area}");
        for start in 0..5 {
            let mut outline = NOTCHED;
            outline.rotate_left(start);
            assert_eq!(places(&outline).0, triangles);
            outline.reverse();
            assert_eq!(places(&outline), (triangles.clone(), -area));
        }
    }

    #[test]
    fn corners_off_the_plane_are_measured_and_crossings_found() {
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]];
        assert!((cut(&bent).off_plane - 0.05).abs() < 1e-12);
        let crossing = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&crossing).off_plane, f64::INFINITY);
        let star = [[0.0, 3.0], [1.8, -2.4], [-2.9, 0.9], [2.9, 0.9], [-1.8, -2.4]];
        assert_eq!(cut(&star.map(|[x, y]| [x, y, 0.0])).off_plane, f64::INFINITY);
    }

    #[test]
    fn repeated_corners_and_lines_have_no_area() {
        let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [3.0, 3.0, 0.0], [2.0, 2.0, 0.0]];
        assert_eq!(cut(&line), PolygonTriangles { triangles: vec![], off_plane: 0.0 });
        assert_eq!(cut(&[[1.0; 3]; 4]), PolygonTriangles { triangles: vec![], off_plane: 0.0 });
        let square = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 1.0]];
        let square = square.map(|[x, y]| [1e4 + x, y, 5.0]);
        assert!((area(&square, &cut(&square)) - DVec3::Z).length() < 1e-9);
    }
}
