//! A grid of columns of 64 voxels, one bit each.

use glam::{DVec2, DVec3};

use crate::geometry::bvh::Aabb;
use crate::relaxation::tuning::{CELL_MAX, CELL_MIN, COLUMNS_MAX, DISC_MAX};

/// Voxels of a column.
pub(crate) const LEVELS: usize = 64;

/// The offsets of a column and of the eight around it, which come after it.
pub(crate) const AROUND: [[i32; 2]; 9] =
    [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];

/// The place of a grid. Columns have an index, voxels of a column a level.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Its lowest corner, m.
    pub low: DVec3,
    /// Horizontal side of a voxel, m.
    pub cell: f64,
    /// Height of a voxel, m.
    pub level: f64,
    /// Number of columns along x and y.
    size: [usize; 2],
}

impl Grid {
    /// A grid that covers a box, with cells fine enough for its columns; `None` if these would be
    /// too large.
    pub fn covering(bounds: &Aabb) -> Option<Self> {
        let extent = bounds.max - bounds.min;
        let count = |cell: f64| {
            let along = |side: f64| libm::floor(side / cell) + 1.0;
            [along(extent.x), along(extent.y)]
        };
        let mut cell = CELL_MIN;
        while cell <= CELL_MAX {
            let [x, y] = count(cell);
            if x * y <= COLUMNS_MAX as f64 {
                let level = (extent.z / (LEVELS as f64 - 1e-6)).max(cell);
                return Some(Self { low: bounds.min, cell, level, size: [x as usize, y as usize] });
            }
            cell *= 1.1;
        }
        None
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The range of columns along an axis that an interval overlaps; empty if it lies outside.
    fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let index = |value: f64| libm::floor((value - self.low[axis]) / self.cell);
        let (first, last) = (index(low).max(0.0), index(high).min(self.size[axis] as f64 - 1.0));
        if first <= last { first as usize..last as usize + 1 } else { 0..0 }
    }

    /// The columns that a rectangle overlaps.
    pub fn columns_in(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = usize> + use<> {
        let (x, y) = (self.range(0, low.x, high.x), self.range(1, low.y, high.y));
        let width = self.size[0];
        y.flat_map(move |y| x.clone().map(move |x| y * width + x))
    }

    /// The voxels of a column that an interval of heights overlaps.
    pub fn levels_in(&self, low: f64, high: f64) -> u64 {
        let level = |z: f64| libm::floor((z - self.low.z) / self.level);
        let (first, last) = (level(low).max(0.0), level(high).min(LEVELS as f64 - 1.0));
        if first > last {
            return 0;
        }
        (u64::MAX << first as u32) & (u64::MAX >> (LEVELS as u32 - 1 - last as u32))
    }

    /// The column and the level of a point in the grid.
    pub fn voxel_of(&self, point: DVec3) -> Option<(usize, usize)> {
        let column = self.columns_in(point.truncate(), point.truncate()).next()?;
        let levels = self.levels_in(point.z, point.z);
        (levels != 0).then(|| (column, levels.trailing_zeros() as usize))
    }

    /// The box of a column between two levels, both included.
    pub fn voxels(&self, column: usize, [first, last]: [usize; 2]) -> Aabb {
        let [x, y] = self.place(column);
        let min = self.low
            + DVec3::new(x as f64 * self.cell, y as f64 * self.cell, first as f64 * self.level);
        let height = (last - first + 1) as f64 * self.level;
        Aabb { min, max: min + DVec3::new(self.cell, self.cell, height) }
    }

    /// The centre of a voxel, m.
    pub fn center(&self, column: usize, level: usize) -> DVec3 {
        self.voxels(column, [level, level]).center()
    }

    /// Half of the diagonal of the face of a voxel in the direction of an axis, m.
    pub fn half_diagonal_across(&self, axis: DVec3) -> f64 {
        let sides = DVec3::new(self.cell, self.cell, self.level);
        0.5 * sides.reject_from(axis).length()
    }

    /// The indices of a column along x and y.
    pub fn place(&self, column: usize) -> [usize; 2] {
        [column % self.size[0], column / self.size[0]]
    }

    /// The column at an offset from another, if it is in the grid.
    pub fn neighbor(&self, column: usize, [dx, dy]: [i32; 2]) -> Option<usize> {
        let [x, y] = self.place(column);
        let (x, y) = (x.checked_add_signed(dx as isize)?, y.checked_add_signed(dy as isize)?);
        (x < self.size[0] && y < self.size[1]).then(|| y * self.size[0] + x)
    }

    /// A column and the eight around it, as far as they are in the grid.
    pub fn around(&self, column: usize) -> impl Iterator<Item = usize> + '_ {
        AROUND.iter().filter_map(move |&offset| self.neighbor(column, offset))
    }

    /// Whether a column is at most `distance` (m) from the grid's border.
    pub fn is_near_border(&self, column: usize, distance: f64) -> bool {
        let cells = libm::ceil(distance / self.cell) as usize;
        let place = self.place(column);
        (0..2).any(|axis| place[axis] < cells || place[axis] + cells >= self.size[axis])
    }
}

/// The voxels within a distance of a voxel: for each column, how many levels up and down.
#[derive(Debug)]
pub(crate) struct Disc {
    columns: Vec<([i32; 2], u32)>,
}

impl Disc {
    /// No voxels, with reserved memory. Allocates.
    pub fn new() -> Self {
        Self { columns: Vec::with_capacity(DISC_MAX) }
    }

    /// Sets the voxels whose nearest point is at most `distance` (m) from that of a voxel. Returns
    /// whether they fit.
    pub fn set(&mut self, grid: &Grid, distance: f64) -> bool {
        self.columns.clear();
        let cells = libm::ceil(distance / grid.cell) as i32 + 1;
        let between = |offset: i32| f64::from((offset.abs() - 1).max(0)) * grid.cell;
        for (dy, dx) in (-cells..=cells).flat_map(|dy| (-cells..=cells).map(move |dx| (dy, dx))) {
            let height_squared =
                distance * distance - between(dx) * between(dx) - between(dy) * between(dy);
            if height_squared < 0.0 {
                continue;
            }
            if self.columns.len() == DISC_MAX {
                return false;
            }
            let levels = libm::floor(libm::sqrt(height_squared) / grid.level) + 1.0;
            self.columns.push(([dx, dy], levels.min(LEVELS as f64) as u32));
        }
        true
    }

    /// The columns of the grid within the distance of a column, each with the levels up and down.
    pub fn around<'a>(
        &'a self,
        grid: &'a Grid,
        column: usize,
    ) -> impl Iterator<Item = (usize, u32)> + 'a {
        self.columns
            .iter()
            .filter_map(move |&(offset, levels)| Some((grid.neighbor(column, offset)?, levels)))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.columns.capacity() * size_of::<([i32; 2], u32)>()
    }
}

/// The voxels at most `levels` above or below those of a set. Each step is at most one more than
/// the reach so far, so that a set cut off at the lowest or highest level has no gap.
pub(crate) fn spread(mut voxels: u64, levels: u32) -> u64 {
    let (mut left, mut step) = (levels.min(LEVELS as u32 - 1), 1);
    while left > 0 && voxels != 0 {
        let shift = step.min(left);
        voxels |= voxels << shift | voxels >> shift;
        (left, step) = (left - shift, 2 * step);
    }
    voxels
}

/// The levels of a set of voxels, lowest first.
pub(crate) fn levels(mut voxels: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let level = (voxels != 0).then(|| voxels.trailing_zeros() as usize)?;
        voxels &= voxels - 1;
        Some(level)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreading_reaches_exactly_the_given_levels() {
        for levels in 0..64 {
            for voxels in [1u64 << 31, 1 << 63 | 1, 0b1001 << 20] {
                let expected = (0..64)
                    .filter(|&z| {
                        (0..64).any(|at: i32| {
                            voxels >> at & 1 == 1 && (at - z).unsigned_abs() <= levels
                        })
                    })
                    .fold(0, |all, z| all | 1u64 << z);
                assert_eq!(spread(voxels, levels), expected, "{voxels:b} {levels}");
            }
        }
    }

    #[test]
    fn a_grid_covers_its_box_and_a_disc_its_ball() {
        let bounds = Aabb { min: DVec3::new(-1.0, 0.5, -0.3), max: DVec3::new(4.0, 2.5, 1.9) };
        let grid = Grid::covering(&bounds).unwrap();
        assert!(grid.columns() <= COLUMNS_MAX && grid.voxel_of(bounds.min - 0.1).is_none());
        let mut disc = Disc::new();
        assert!(disc.set(&grid, 0.7));
        let corner = grid.voxel_of(bounds.min).unwrap();
        assert_eq!(corner, (0, 0));
        assert!(grid.voxel_of(bounds.max).is_some());
        for step in 0..200 {
            let angle = f64::from(step) * 0.7;
            let from = DVec3::new(1.0, 1.3, 0.5);
            let to = from + 0.7 * DVec3::new(libm::cos(angle) * 0.8, libm::sin(angle) * 0.8, 0.6);
            let [one, other] = [from, to].map(|point| grid.voxel_of(point).unwrap());
            let (_, levels) = disc.around(&grid, one.0).find(|(at, _)| *at == other.0).unwrap();
            assert!(spread(1 << one.1, levels) >> other.1 & 1 == 1, "{step}");
        }
    }
}
