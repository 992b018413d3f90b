//! Where a leg reaches from the ground without passing through walls.
//!
//! A leg is a curve from the ground to the root, of bounded length, that no wall cuts. On the grid
//! it is followed in pieces as long as a voxel: a piece stays within the voxels beside the one in
//! which it begins, and goes from voxel to voxel through faces that are not inside a wall. Walls
//! are boxes that stand upright, made thinner by the longest part of the curve that no collision
//! shape covers. All other shapes are left out, which makes more possible.

use glam::DVec2;

use crate::collision::model::CollisionModel;
use crate::collision::upright_box::UprightBox;
use crate::relaxation::grid::{Grid, LEVELS, spread};
use crate::relaxation::tuning::{COLUMNS_MAX, LEG_COLUMNS_PER_UNIT};

/// The columns beside a column, with its own.
const AROUND: [[i32; 2]; 9] =
    [[-1, -1], [0, -1], [1, -1], [-1, 0], [0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// How far the pieces have come.
#[derive(Debug, Clone, Copy, Default)]
struct Pieces {
    /// Pieces that are left, the current one included.
    left: usize,
    /// The next column of the current sweep.
    column: usize,
    /// Whether the current sweep has reached a voxel.
    has_grown: bool,
}

/// The voxels that legs reach.
#[derive(Debug)]
pub(crate) struct LegReach {
    /// By column: the voxels reached.
    pub reached: Vec<u64>,
    /// Those that the pieces before the current one reach.
    before: Vec<u64>,
    /// By axis and column: the voxels whose face toward larger coordinates is in a wall.
    blocked: [Vec<u64>; 3],
    pieces: Pieces,
    is_begun: bool,
}

impl LegReach {
    /// Nothing reached, with reserved memory. Allocates.
    pub fn new() -> Self {
        let columns = || vec![0; COLUMNS_MAX];
        Self {
            reached: columns(),
            before: columns(),
            blocked: [columns(), columns(), columns()],
            pieces: Pieces::default(),
            is_begun: false,
        }
    }

    /// Prepares for another problem.
    pub fn clear(&mut self) {
        self.is_begun = false;
    }

    /// Begins at the ground that steps reach, with curves of `length` (m) of which at most `gap`
    /// (m) in a piece is not covered. Returns `false` if it has begun before.
    pub fn begin(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        ground: &[u64],
        [length, gap]: [f64; 2],
    ) -> bool {
        if std::mem::replace(&mut self.is_begun, true) {
            return false;
        }
        let columns = grid.columns();
        self.reached[..columns].copy_from_slice(&ground[..columns]);
        self.before[..columns].copy_from_slice(&ground[..columns]);
        self.blocked.iter_mut().for_each(|blocked| blocked[..columns].fill(0));
        for wall in collision.upright_boxes() {
            self.block(grid, &wall, 0.5 * gap);
        }
        let left = libm::ceil(length / grid.cell) as usize;
        self.pieces = Pieces { left, column: 0, has_grown: false };
        true
    }

    /// Blocks the faces inside a wall whose sides are moved inward by `inset` (m).
    fn block(&mut self, grid: &Grid, wall: &UprightBox, inset: f64) {
        let half = wall.half_extents - inset;
        if half.min_element() <= 0.0 {
            return;
        }
        let heights = [wall.center.z - half.z, wall.center.z + half.z];
        let (inside, planes) = (grid.levels_within(heights), grid.planes_within(heights));
        let reach = DVec2::splat(half.truncate().length());
        let center = wall.center.truncate();
        let is_in = |point: DVec2| {
            let offset = point - center;
            wall.axis.dot(offset).abs() <= half.x && wall.axis.perp_dot(offset).abs() <= half.y
        };
        for column in grid.columns_in(center - reach, center + reach) {
            let bounds = grid.voxels(column, [0, 0]);
            let (low, high) = (bounds.min.truncate(), bounds.max.truncate());
            let corners =
                [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(is_in);
            self.blocked[0][column] |= if corners[1] && corners[2] { inside } else { 0 };
            self.blocked[1][column] |= if corners[2] && corners[3] { inside } else { 0 };
            self.blocked[2][column] |= if corners == [true; 4] { planes } else { 0 };
        }
    }

    /// Does one unit of work. Returns whether all pieces have come to their ends.
    pub fn advance(&mut self, grid: &Grid) -> bool {
        let columns = grid.columns();
        let last = (self.pieces.column + LEG_COLUMNS_PER_UNIT).min(columns);
        for column in self.pieces.column..last {
            self.sweep(grid, column);
        }
        self.pieces.column = last;
        if last == columns {
            self.end_sweep(columns);
        }
        self.pieces.left == 0
    }

    /// A sweep that reached nothing ends the pieces.
    fn end_sweep(&mut self, columns: usize) {
        self.pieces.column = 0;
        if !std::mem::take(&mut self.pieces.has_grown) {
            self.pieces.left = self.pieces.left.saturating_sub(1);
            self.before[..columns].copy_from_slice(&self.reached[..columns]);
        }
    }

    /// Adds the voxels of a column that a face joins to reached ones beside them.
    fn sweep(&mut self, grid: &Grid, column: usize) {
        let here = self.reached[column];
        let near = AROUND.iter().filter_map(|&offset| grid.neighbor(column, offset));
        let within = spread(near.fold(0, |all, other| all | self.before[other]), 1);
        if within & !here == 0 {
            return;
        }
        let [x, y, z] = &self.blocked;
        let mut joined = (here & !z[column]) << 1 | here >> 1 & !z[column];
        for (blocked, ahead) in [(x, [1, 0]), (y, [0, 1])] {
            if let Some(other) = grid.neighbor(column, ahead) {
                joined |= self.reached[other] & !blocked[column];
            }
            if let Some(other) = grid.neighbor(column, ahead.map(|offset: i32| -offset)) {
                joined |= self.reached[other] & !blocked[other];
            }
        }
        let new = joined & within & !here;
        if new != 0 {
            self.reached[column] |= new;
            self.pieces.has_grown = true;
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let columns = self.reached.len() + self.before.len();
        (columns + self.blocked.iter().map(Vec::len).sum::<usize>()) * LEVELS / 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bvh::Aabb;
    use glam::DVec3;

    /// The voxels reached from a point of a floor beside a wall along x from `wall_from` on.
    fn reached_beside_a_wall(wall_from: f64, length: f64) -> (Grid, LegReach) {
        let bounds = Aabb { min: DVec3::new(-2.0, -2.0, 0.0), max: DVec3::new(2.0, 2.0, 2.0) };
        let grid = Grid::covering(&bounds).unwrap();
        let mut legs = LegReach::new();
        let half = 0.5 * (2.0 - wall_from);
        let wall = UprightBox {
            center: DVec3::new(wall_from + half, 0.5, 1.0),
            axis: DVec2::X,
            half_extents: DVec3::new(half + 1e-3, 0.05, 1.1),
        };
        legs.block(&grid, &wall, 0.0);
        let (column, level) = grid.voxel_of(DVec3::new(0.0, 0.0, 0.01)).unwrap();
        legs.reached[column] = 1 << level;
        legs.before[column] = 1 << level;
        legs.pieces.left = libm::ceil(length / grid.cell) as usize;
        while !legs.advance(&grid) {}
        (grid, legs)
    }

    fn reaches(grid: &Grid, legs: &LegReach, point: DVec3) -> bool {
        let (column, level) = grid.voxel_of(point).unwrap();
        legs.reached[column] >> level & 1 == 1
    }

    #[test]
    fn a_leg_reaches_what_is_near_and_nothing_behind_a_wall() {
        let behind = DVec3::new(0.0, 0.8, 0.5);
        let (grid, legs) = reached_beside_a_wall(1.5, 1.0);
        assert!(reaches(&grid, &legs, behind), "the wall begins beyond it");
        assert!(reaches(&grid, &legs, DVec3::new(0.5, -0.5, 0.6)));
        assert!(!reaches(&grid, &legs, DVec3::new(-1.5, 0.0, 0.5)), "too far");
        let (grid, legs) = reached_beside_a_wall(-2.0, 1.0);
        assert!(!reaches(&grid, &legs, behind));
        assert!(reaches(&grid, &legs, DVec3::new(0.0, 0.3, 0.5)), "before the wall");
    }

    #[test]
    fn around_the_end_of_a_wall_the_way_counts() {
        let behind = DVec3::new(0.0, 0.8, 0.1);
        assert!({
            let (grid, legs) = reached_beside_a_wall(-0.2, 1.2);
            reaches(&grid, &legs, behind)
        });
        assert!({
            let (grid, legs) = reached_beside_a_wall(-1.4, 1.2);
            !reaches(&grid, &legs, behind)
        });
    }
}
