//! Height maps.

/// Heights on a grid: the surface of terrain from a depth camera, a simulator or a generator.
///
/// Row `i`, column `j` is at x = `j` · `spacing`, y = `i` · `spacing` in the map's frame. Each cell
/// between four points becomes two triangles. Cells with a height that is not finite are left open.
///
/// # Examples
/// ```
/// use surefoot::{HeightMap, Pose, World};
///
/// let heights: Vec<f64> = (0..50 * 100).map(|at| 0.01 * f64::from(at % 3)).collect();
/// let map = HeightMap { heights: &heights, columns: 100, spacing: 0.1 };
/// let world = World::builder().height_map("ground", Pose::at(-1.0, -2.5, 0.0), &map).build()?;
/// # Ok::<(), surefoot::WorldError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightMap<'a> {
    /// Heights row by row, m.
    pub heights: &'a [f64],
    /// Number of columns. What exceeds complete rows is ignored.
    pub columns: usize,
    /// Distance of neighbouring points along x and y, m.
    pub spacing: f64,
}

impl HeightMap<'_> {
    /// Vertices and triangles, counter-clockwise seen from above.
    pub(crate) fn surface(&self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let columns = self.columns.max(1);
        let rows = self.heights.len() / columns;
        let height = |row: usize, column: usize| self.heights[row * columns + column];
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let mut index_of = vec![0; rows * columns];
        for (at, index) in index_of.iter_mut().enumerate() {
            let (row, column) = (at / columns, at % columns);
            if height(row, column).is_finite() {
                *index = vertices.len() as u32;
                let [x, y] = [column, row].map(|place| place as f64 * self.spacing);
                vertices.push([x, y, height(row, column)]);
            }
        }
        for row in 1..rows {
            for column in 1..columns {
                let corners =
                    [(row - 1, column - 1), (row - 1, column), (row, column), (row, column - 1)];
                if corners.iter().all(|&(row, column)| height(row, column).is_finite()) {
                    let [a, b, c, d] =
                        corners.map(|(row, column)| index_of[row * columns + column]);
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        (vertices, triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_become_triangles_that_face_up_and_unknown_heights_stay_open() {
        let heights = [0.0, 1.0, 2.0, 3.0, 4.0, f64::NAN];
        let map = HeightMap { heights: &heights, columns: 3, spacing: 0.5 };
        let (vertices, triangles) = map.surface();
        assert_eq!(vertices.len(), 5);
        assert_eq!(vertices[4], [0.5, 0.5, 4.0]);
        assert_eq!(triangles, [[0, 1, 4], [0, 4, 3]]);
        for triangle in triangles {
            let [a, b, c] = triangle.map(|corner| glam::DVec3::from(vertices[corner as usize]));
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }
}
