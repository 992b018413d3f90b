//! A set of voxels that grows step by step.

use crate::relaxation::column_queue::ColumnQueue;
use crate::relaxation::grid::Grid;
use crate::relaxation::tuning::COLUMNS_MAX;

/// A set of voxels, by column, with those that are new in a step.
#[derive(Debug)]
pub(crate) struct Flood {
    /// All of its voxels.
    pub voxels: Vec<u64>,
    /// Those whose surroundings are searched in the current step.
    fresh: Vec<u64>,
    /// Those for the next step.
    next: Vec<u64>,
    /// The columns of the current step, then those of the next one.
    queue: ColumnQueue,
    /// Columns of the current step that are left.
    left: usize,
}

impl Flood {
    /// No voxels, with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            voxels: vec![0; COLUMNS_MAX],
            fresh: vec![0; COLUMNS_MAX],
            next: vec![0; COLUMNS_MAX],
            queue: ColumnQueue::new(2 * COLUMNS_MAX),
            left: 0,
        }
    }

    /// Removes all voxels.
    pub fn clear(&mut self, grid: &Grid) {
        for voxels in [&mut self.voxels, &mut self.fresh, &mut self.next] {
            voxels[..grid.columns()].fill(0);
        }
        self.queue.clear();
        self.left = 0;
    }

    /// Adds voxels; their surroundings are searched in the next step.
    pub fn add(&mut self, column: usize, voxels: u64) {
        let new = voxels & !self.voxels[column];
        if new == 0 {
            return;
        }
        if self.next[column] == 0 {
            self.queue.push(column);
        }
        self.voxels[column] |= new;
        self.next[column] |= new;
    }

    /// The next column of the current step, with its fresh voxels.
    pub fn pop(&mut self) -> Option<(usize, u64)> {
        self.left = self.left.checked_sub(1)?;
        let column = self.queue.pop()?;
        Some((column, std::mem::take(&mut self.fresh[column])))
    }

    /// Begins the next step. Returns whether it has any column.
    pub fn step(&mut self) -> bool {
        std::mem::swap(&mut self.fresh, &mut self.next);
        self.left = self.queue.len();
        self.left > 0
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let lists = [&self.voxels, &self.fresh, &self.next];
        lists.iter().map(|list| size_of_val(list.as_slice())).sum::<usize>() + self.queue.bytes()
    }
}
