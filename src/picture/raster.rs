//! Filling triangles.

use glam::{DVec2, DVec3};

use crate::picture::camera::Size;

/// Calls `plot` with the pixel's index, the barycentric weights and the interpolated third
/// coordinate, for each pixel whose centre a triangle covers. `corners` are column, row and any
/// third coordinate that is affine on the raster. A centre on an edge that two triangles share
/// belongs to exactly one of them.
pub fn fill_triangle(corners: [DVec3; 3], size: Size, mut plot: impl FnMut(usize, [f64; 3], f64)) {
    let area = edge(corners[0], corners[1], corners[2].truncate());
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let sign = area.signum();
    let owned = [0, 1, 2].map(|i| owns_border(corners[(i + 1) % 3], corners[(i + 2) % 3], sign));
    let [columns, rows] = covered(&corners, size);
    for row in rows {
        for column in columns.clone() {
            let centre = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            let weights =
                [0, 1, 2].map(|i| sign * edge(corners[(i + 1) % 3], corners[(i + 2) % 3], centre));
            if (0..3).all(|i| weights[i] > 0.0 || (weights[i] == 0.0 && owned[i])) {
                let weights = weights.map(|weight| weight / (sign * area));
                let third = (0..3).map(|i| weights[i] * corners[i].z).sum();
                plot(row * size.width + column, weights, third);
            }
        }
    }
}

/// Twice the signed area of the triangle a, b, p.
fn edge(a: DVec3, b: DVec3, p: DVec2) -> f64 {
    (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
}

/// Whether the triangle owns the pixel centres on its edge from a to b (the top-left rule).
fn owns_border(a: DVec3, b: DVec3, sign: f64) -> bool {
    let along = sign * (b - a);
    along.y < 0.0 || (along.y == 0.0 && along.x > 0.0)
}

/// The columns and rows that a triangle may cover.
fn covered(corners: &[DVec3; 3], size: Size) -> [std::ops::Range<usize>; 2] {
    let range = |axis: usize, limit: usize| {
        let low = corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
        let clamp = |value: f64| value.clamp(0.0, limit as f64) as usize;
        clamp(libm::floor(low))..clamp(libm::ceil(high))
    };
    [range(0, size.width), range(1, size.height)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 20, height: 12 };

    #[test]
    fn two_triangles_share_a_diagonal_without_gap_or_overlap() {
        let [a, b, c, d] = [[2.5, 1.5], [12.5, 1.5], [12.5, 11.5], [2.5, 11.5]]
            .map(|[x, y]| DVec3::new(x, y, 1.0));
        let mut hits = vec![0; SIZE.pixels()];
        for triangle in [[a, b, c], [a, d, c]] {
            fill_triangle(triangle, SIZE, |index, _, _| hits[index] += 1);
        }
        assert_eq!(hits.iter().sum::<i32>(), 100);
        assert!(hits.iter().all(|&hit| hit <= 1));
    }

    #[test]
    fn the_third_coordinate_is_interpolated() {
        let corners =
            [DVec3::new(0.0, 0.0, 0.0), DVec3::new(20.0, 0.0, 20.0), DVec3::new(0.0, 12.0, 0.0)];
        let mut plotted = 0;
        fill_triangle(corners, SIZE, |index, _, third| {
            plotted += 1;
            assert!((third - ((index % 20) as f64 + 0.5)).abs() < 1e-9);
        });
        assert!(plotted > 100);
    }

    #[test]
    fn far_outside_is_clipped() {
        let corners =
            [DVec3::new(-1e6, -1e6, 0.0), DVec3::new(1e6, -1e6, 0.0), DVec3::new(0.0, 1e6, 0.0)];
        let mut plotted = 0;
        fill_triangle(corners, SIZE, |_, _, _| plotted += 1);
        assert_eq!(plotted, SIZE.pixels());
    }
}
