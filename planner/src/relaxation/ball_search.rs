//! Where a ball in the robot's root passes between the world and the reach of the legs.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::collision::model::CollisionModel;
use crate::relaxation::grid::{Disc, Grid, LEVELS, spread};
use crate::relaxation::tuning::{COLUMNS_MAX, PASSED_MAX, TESTED_RADIUS_MIN, VOXELS_PER_UNIT};

/// The six voxels beside a voxel: offsets of the column, and of the level.
const BESIDE: [([i32; 2], i32); 6] =
    [([1, 0], 0), ([-1, 0], 0), ([0, 1], 0), ([0, -1], 0), ([0, 0], 1), ([0, 0], -1)];

/// How the search for a way of the ball ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Passage {
    /// The goal is reached, or the grid is left.
    Open,
    /// The bound of the voxels is reached.
    Undecided,
    /// The shape in the way where the ball came nearest to the goal, and the ball's centre there.
    Closed(usize, DVec3),
    /// The legs reach no farther, and no shape is in the way.
    OutOfReach,
}

/// A voxel that the ball passes, by its distance from the goal in cells, squared.
type Entry = (Reverse<u64>, Reverse<u32>);

/// The search for a way of the ball from voxel to voxel, nearest to the goal first.
#[derive(Debug)]
pub(crate) struct BallSearch {
    /// Voxels within a leg's reach of reached ground, by column.
    near: Vec<u64>,
    /// Voxels that are passed or wait for it.
    seen: Vec<u64>,
    waiting: BinaryHeap<Entry>,
    /// Number of voxels that the ball has entered.
    entered: usize,
    goal: DVec3,
    goal_voxel: (usize, usize),
    /// Radius of the ball, m.
    radius: f64,
    /// The blocked face nearest to the goal: its shape, its centre and its distance, m.
    blocked: Option<(usize, DVec3, f64)>,
}

impl BallSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            near: vec![0; COLUMNS_MAX],
            seen: vec![0; COLUMNS_MAX],
            waiting: BinaryHeap::with_capacity(PASSED_MAX),
            entered: 0,
            goal: DVec3::ZERO,
            goal_voxel: (0, 0),
            radius: 0.0,
            blocked: None,
        }
    }

    /// Begins with a ball of `radius` (m) and no voxels within reach.
    pub fn begin(&mut self, grid: &Grid, radius: f64) {
        self.near[..grid.columns()].fill(0);
        self.radius = radius;
    }

    /// Whether a grid of this coarseness shows anything about the ball.
    pub fn shows(&self, grid: &Grid) -> bool {
        self.radius - grid.half_diagonal_across(DVec3::X) >= TESTED_RADIUS_MIN
    }

    /// The voxels within reach, by column.
    pub fn near(&self) -> &[u64] {
        &self.near
    }

    /// Begins a search of the ball's centre from one place to another. Returns whether both are in
    /// the grid.
    pub fn start(&mut self, grid: &Grid, [from, goal]: [DVec3; 2]) -> bool {
        self.seen[..grid.columns()].fill(0);
        self.waiting.clear();
        (self.blocked, self.entered) = (None, 0);
        let [Some(first), Some(last)] = [from, goal].map(|end| grid.voxel_of(end)) else {
            return false;
        };
        (self.goal, self.goal_voxel) = (goal, last);
        self.add(grid, first);
        true
    }

    /// Extends the voxels within reach by those of the reached ground of one column.
    pub fn extend(&mut self, grid: &Grid, disc: &Disc, column: usize, reached: u64) {
        for (other, levels) in disc.around(grid, column) {
            self.near[other] |= spread(reached, levels);
        }
    }

    fn add(&mut self, grid: &Grid, (column, level): (usize, usize)) {
        self.seen[column] |= 1 << level;
        self.entered += 1;
        let away = (grid.center(column, level) - self.goal) / grid.cell;
        let index = (column * LEVELS + level) as u32;
        self.waiting.push((Reverse(away.length_squared() as u64), Reverse(index)));
    }

    /// Does one unit of work. `is_open` returns whether the ball leaves the grid in a column.
    pub fn advance(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        is_open: impl Fn(usize) -> bool,
    ) -> Option<Passage> {
        for _ in 0..VOXELS_PER_UNIT {
            let Some((_, Reverse(index))) = self.waiting.pop() else { return Some(self.closed()) };
            let (column, level) = (index as usize / LEVELS, index as usize % LEVELS);
            if (column, level) == self.goal_voxel || is_open(column) {
                return Some(Passage::Open);
            }
            if self.entered + BESIDE.len() > PASSED_MAX {
                return Some(Passage::Undecided);
            }
            for (offset, up) in BESIDE {
                let beside =
                    level.checked_add_signed(up as isize).filter(|beside| *beside < LEVELS);
                let beside = grid.neighbor(column, offset).zip(beside);
                if let Some(beside) = beside {
                    self.enter(grid, collision, (column, level), beside);
                }
            }
        }
        None
    }

    /// Adds a voxel if the ball may come into it from the one beside it: through some point of the
    /// face between both.
    fn enter(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        from: (usize, usize),
        voxel: (usize, usize),
    ) {
        let (column, level) = voxel;
        if self.near[column] & !self.seen[column] & 1 << level == 0 {
            return;
        }
        let [here, there] = [from, voxel].map(|(column, level)| grid.center(column, level));
        let radius = self.radius - grid.half_diagonal_across(there - here);
        let face = here.midpoint(there);
        let Some(shape) = collision.ball_hit(face, radius) else { return self.add(grid, voxel) };
        let away = face.distance(self.goal);
        if self.blocked.is_none_or(|(.., nearest)| away < nearest) {
            self.blocked = Some((shape, face, away));
        }
    }

    fn closed(&self) -> Passage {
        self.blocked.map_or(Passage::OutOfReach, |(shape, at, _)| Passage::Closed(shape, at))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        size_of_val(self.near.as_slice())
            + size_of_val(self.seen.as_slice())
            + self.waiting.capacity() * size_of::<Entry>()
    }
}
