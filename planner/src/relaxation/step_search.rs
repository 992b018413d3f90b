//! Which ground steps reach from one end.

use glam::DVec3;

use crate::relaxation::column_queue::ColumnQueue;
use crate::relaxation::grid::{Disc, Grid, spread};
use crate::relaxation::tuning::{COLUMNS_MAX, COLUMNS_PER_UNIT};

/// Levels by which continuous ground rises or falls at most from one column to the next.
const EDGE_LEVELS: u32 = 2;

/// The voxels of ground that steps reach from one end, and those from which it goes on.
#[derive(Debug)]
pub(crate) struct StepSearch {
    /// The reached voxels, by column.
    pub reached: Vec<u64>,
    /// Whether steps reach beyond the grid.
    pub is_open: bool,
    /// Whether they reach the other end.
    pub has_arrived: bool,
    /// Reached voxels whose surroundings are not searched yet.
    fresh: Vec<u64>,
    queue: ColumnQueue,
}

impl StepSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            reached: vec![0; COLUMNS_MAX],
            is_open: false,
            has_arrived: false,
            fresh: vec![0; COLUMNS_MAX],
            queue: ColumnQueue::new(COLUMNS_MAX),
        }
    }

    /// Begins on the ground within `radius` (m) of the soles of one end.
    pub fn begin(&mut self, grid: &Grid, ground: &[u64], soles: &[DVec3], radius: f64) {
        self.reached[..grid.columns()].fill(0);
        self.fresh[..grid.columns()].fill(0);
        self.queue.clear();
        self.is_open = false;
        for sole in soles {
            let (low, high) = (sole - DVec3::splat(radius), sole + DVec3::splat(radius));
            for column in grid.columns_in(low.truncate(), high.truncate()) {
                self.add(column, ground[column] & grid.levels_in(low.z, high.z));
            }
            if let Some((column, level)) = grid.voxel_of(*sole) {
                self.add(column, 1 << level);
            }
        }
    }

    fn add(&mut self, column: usize, voxels: u64) {
        let new = voxels & !self.reached[column];
        if new == 0 {
            return;
        }
        if self.fresh[column] == 0 {
            self.queue.push(column);
        }
        self.reached[column] |= new;
        self.fresh[column] |= new;
    }

    /// Does one unit of work. Returns whether all ground is reached that steps reach.
    pub fn advance(&mut self, grid: &Grid, ground: &[u64], disc: &Disc, span: f64) -> bool {
        for _ in 0..COLUMNS_PER_UNIT {
            let Some(column) = self.queue.pop() else { return true };
            let fresh = std::mem::take(&mut self.fresh[column]);
            self.is_open |= grid.is_near_border(column, span);
            for (other, levels) in disc.around(grid, column) {
                if ground[other] & !self.reached[other] != 0 {
                    self.add(other, ground[other] & spread(fresh, levels));
                }
            }
        }
        false
    }

    /// Whether a voxel within `radius` (m) of any of these soles is reached.
    pub fn reaches(&self, grid: &Grid, soles: &[DVec3], radius: f64) -> bool {
        soles.iter().any(|sole| {
            let (low, high) = (sole - DVec3::splat(radius), sole + DVec3::splat(radius));
            let mut columns = grid.columns_in(low.truncate(), high.truncate());
            columns.any(|column| self.reached[column] & grid.levels_in(low.z, high.z) != 0)
        })
    }

    /// The reached levels of a column and of the eight around it.
    pub fn reached_around(&self, grid: &Grid, column: usize) -> u64 {
        grid.around(column).fold(0, |all, other| all | self.reached[other])
    }

    /// Whether the reached ground ends beside a column.
    pub fn is_edge(&self, grid: &Grid, column: usize) -> bool {
        let here = self.reached[column];
        let ends_beside = |offset: [i32; 2]| {
            let beside = grid.neighbor(column, offset).map_or(0, |other| self.reached[other]);
            here & !spread(beside, EDGE_LEVELS) != 0
        };
        [[1, 0], [-1, 0], [0, 1], [0, -1]].into_iter().any(ends_beside)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        size_of_val(self.reached.as_slice())
            + size_of_val(self.fresh.as_slice())
            + self.queue.bytes()
    }
}
