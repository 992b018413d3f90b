//! Where the legs, as curves of bounded length, hold the root over the ground that steps reach, and
//! which of these places the root reaches from one end.

use glam::DVec3;

use crate::collision::model::CollisionModel;
use crate::relaxation::flood::Flood;
use crate::relaxation::free_voxels::{FreeVoxels, distance};
use crate::relaxation::grid::{Disc, Grid, levels, spread};
use crate::relaxation::leg_curve::LegCurve;
use crate::relaxation::tuning::{
    COLUMNS_MAX, CURVE_RADIUS, FOOT_SINK, TOLERANCE, TOUCHING, VISITS_PER_UNIT,
};

/// Steps that a part of a leg that is not covered counts for: its ends are at most as many voxels
/// apart.
const GAP_STEPS: u32 = 3;

/// What the search for the root's way shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RootWay {
    /// The other end is reached, or the grid is left.
    Open,
    /// The end is not reached: the shape in the way and the place that are nearest to it, if any.
    Closed(Option<(usize, DVec3)>),
}

/// The voxels that are next along the legs.
#[derive(Debug, Clone, Copy)]
enum Spread {
    /// The voxels beside those of the current step.
    Beside,
    /// The voxels across gaps from those two steps before, from a column on.
    Across(usize),
}

/// The search, over voxels that the shapes of the world do not fill.
#[derive(Debug)]
pub(crate) struct CurveSearch {
    /// Points of legs that stand on reached ground.
    legs: Flood,
    /// Places of the root.
    root: Flood,
    free: FreeVoxels,
    /// The leg voxels of the current step, of the one before, and of the one before that.
    recent: [Vec<u64>; 3],
    /// Voxels to which a part that is not covered leads.
    disc: Disc,
    curve: Option<LegCurve>,
    /// Steps along the legs that are left.
    steps_left: u32,
    spread_next: Spread,
    /// The filled voxel beside the root's places that is nearest to the root's goal: the square of
    /// its distance (m2), its column and its level.
    blocked: Option<(f64, usize, usize)>,
}

impl CurveSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            legs: Flood::new(),
            root: Flood::new(),
            free: FreeVoxels::new(),
            recent: [(); 3].map(|()| vec![0; COLUMNS_MAX]),
            disc: Disc::new(),
            curve: None,
            steps_left: 0,
            spread_next: Spread::Beside,
            blocked: None,
        }
    }

    /// Begins with legs of a curve, and no ground. Returns whether the voxels suit the curve.
    pub fn begin(&mut self, grid: &Grid, curve: &LegCurve) -> bool {
        self.legs.clear(grid);
        self.free.clear(grid);
        self.recent.iter_mut().for_each(|voxels| voxels[..grid.columns()].fill(0));
        // A step that would end in a part that is not covered ends before it.
        self.steps_left = libm::ceil(curve.length / grid.cell) as u32 + GAP_STEPS * curve.gaps + 1;
        (self.curve, self.spread_next) = (Some(*curve), Spread::Across(grid.columns()));
        curve.gap <= f64::from(GAP_STEPS) * grid.cell
            && curve.foot_depth > FOOT_SINK
            && self.disc.set(grid, curve.gap)
    }

    /// Adds the first covered points of legs whose feet touch ground at heights from `low` to
    /// `high` (m) near a column. Returns the number of voxels that were tested.
    pub fn add_ground(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        column: usize,
        [low, high]: [f64; 2],
    ) -> u32 {
        let Some(curve) = self.curve else { return 0 };
        let mut place = grid.voxels(column, [0, 0]);
        (place.min.z, place.max.z) = (low - FOOT_SINK, high + curve.to_foot + TOLERANCE);
        let foot = collision.free_part(&place, curve.foot_depth - FOOT_SINK);
        let Some((foot, _)) = foot else { return 1 };
        let to_leg = curve.to_leg + TOUCHING;
        let mut around = foot.grown(to_leg);
        if curve.is_above {
            around.min.z = foot.min.z;
        }
        let mut tested = 1;
        for other in grid.columns_in(around.min.truncate(), around.max.truncate()) {
            let wanted = grid.levels_in(around.min.z, around.max.z) & !self.legs.voxels[other];
            let (open, count) = self.free.test(grid, collision, (other, wanted), CURVE_RADIUS);
            tested += count;
            let is_near = |level: &usize| {
                let mut part = self.free.part(grid, (other, *level));
                (part.min, part.max) = (part.min.max(around.min), part.max.min(around.max));
                let is_partial = self.free.partial[other] >> level & 1 == 1;
                let free = if is_partial {
                    collision.free_part(&part, CURVE_RADIUS).map(|(free, _)| free)
                } else {
                    Some(part)
                };
                free.is_some_and(|free| distance(&free, &foot) <= to_leg)
            };
            let near = levels(open).filter(is_near).fold(0, |all, level| all | 1u64 << level);
            self.legs.add(other, near);
        }
        tested
    }

    /// Does one unit of work along the legs, through voxels of `near`, by column. Returns whether
    /// all of their steps are done.
    pub fn extend_legs(&mut self, grid: &Grid, collision: &CollisionModel, near: &[u64]) -> bool {
        let mut visits = 0;
        while visits < VISITS_PER_UNIT {
            match self.spread_next {
                Spread::Beside => match self.legs.pop() {
                    None => self.spread_next = Spread::Across(0),
                    Some((column, fresh)) => {
                        self.recent[0][column] = fresh;
                        visits += 1 + self.add_beside(grid, (collision, near), column, fresh);
                    }
                },
                Spread::Across(column) if column < grid.columns() => {
                    visits += self.add_across(grid, (collision, near), column);
                    self.spread_next = Spread::Across(column + 1);
                }
                Spread::Across(_) => {
                    if self.steps_left == 0 {
                        return true;
                    }
                    self.steps_left -= 1;
                    self.recent.rotate_right(1);
                    self.recent[0][..grid.columns()].fill(0);
                    self.legs.step();
                    self.spread_next = Spread::Beside;
                    visits += 1;
                }
            }
        }
        false
    }

    /// Adds the voxels beside fresh ones of a column: a covered point of a leg may lie there at
    /// most the side of a voxel away. Returns the number of voxels that were tested.
    fn add_beside(
        &mut self,
        grid: &Grid,
        (collision, within): (&CollisionModel, &[u64]),
        column: usize,
        fresh: u64,
    ) -> u32 {
        let mut tested = 0;
        for other in grid.around(column) {
            let new = spread(fresh, 1) & within[other] & !self.legs.voxels[other];
            let (open, count) = self.free.test(grid, collision, (other, new), CURVE_RADIUS);
            tested += count;
            let near = self.free.near(grid, [(column, fresh), (other, open)], (1, grid.cell));
            self.legs.add(other, near);
        }
        tested
    }

    /// Adds the voxels to which a part that is not covered leads from a column. Returns the number
    /// of voxels that were tested.
    fn add_across(
        &mut self,
        grid: &Grid,
        (collision, within): (&CollisionModel, &[u64]),
        column: usize,
    ) -> u32 {
        let (from, gap) = (self.recent[2][column], self.curve.map_or(0.0, |curve| curve.gap));
        if from == 0 || gap == 0.0 {
            return 0;
        }
        let mut tested = 1;
        for (other, reach) in self.disc.around(grid, column) {
            let new = spread(from, reach) & within[other] & !self.legs.voxels[other];
            let (open, count) = self.free.test(grid, collision, (other, new), CURVE_RADIUS);
            tested += count;
            let near = self.free.near(grid, [(column, from), (other, open)], (reach, gap));
            self.legs.add(other, near);
        }
        tested
    }

    /// Begins the way of the root from a place. Returns whether it is in the grid.
    pub fn start_root(&mut self, grid: &Grid, from: DVec3) -> bool {
        self.root.clear(grid);
        self.blocked = None;
        let Some((column, level)) = grid.voxel_of(from) else { return false };
        self.root.add(column, 1 << level);
        self.root.step()
    }

    /// Does one unit of work along the way of the root to a place, through voxels of `near`, by
    /// column. `is_open` returns whether it leaves the grid in a column.
    pub fn pass(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        (goal, near): (DVec3, &[u64]),
        is_open: impl Fn(usize) -> bool,
    ) -> Option<RootWay> {
        let Some((goal_column, goal_level)) = grid.voxel_of(goal) else {
            return Some(RootWay::Open);
        };
        for _ in 0..VISITS_PER_UNIT / 2 {
            if self.root.voxels[goal_column] >> goal_level & 1 == 1 {
                return Some(RootWay::Open);
            }
            let Some((column, fresh)) = self.root.pop() else {
                if self.root.step() {
                    continue;
                }
                return Some(RootWay::Closed(self.obstacle(grid, collision)));
            };
            if is_open(column) {
                return Some(RootWay::Open);
            }
            for other in grid.around(column) {
                let beside = spread(fresh, 1);
                self.note_blocked(grid, goal, other, beside & self.free.filled[other]);
                let within = self.legs.voxels[other] & near[other];
                let new = beside & within & !self.root.voxels[other];
                let joined = self.free.near(grid, [(column, fresh), (other, new)], (1, TOUCHING));
                self.root.add(other, joined);
            }
        }
        None
    }

    fn note_blocked(&mut self, grid: &Grid, goal: DVec3, column: usize, filled: u64) {
        for level in levels(filled) {
            let away = grid.center(column, level).distance_squared(goal);
            if self.blocked.is_none_or(|(nearest, ..)| away < nearest) {
                self.blocked = Some((away, column, level));
            }
        }
    }

    fn obstacle(&self, grid: &Grid, collision: &CollisionModel) -> Option<(usize, DVec3)> {
        let (_, column, level) = self.blocked?;
        let center = grid.center(column, level);
        Some((collision.shape_near(center, CURVE_RADIUS)?, center))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.legs.bytes()
            + self.root.bytes()
            + self.free.bytes()
            + self.disc.bytes()
            + self.recent.iter().map(|voxels| size_of_val(voxels.as_slice())).sum::<usize>()
    }
}
