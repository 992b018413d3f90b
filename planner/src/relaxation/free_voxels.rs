//! Which voxels the world fills, and which part of the others it leaves free.

use glam::DVec3;

use crate::collision::model::CollisionModel;
use crate::geometry::bvh::Aabb;
use crate::relaxation::grid::{Grid, LEVELS, levels, spread};
use crate::relaxation::tuning::COLUMNS_MAX;

/// Parts of a side in which a free part is stored.
const FINENESS: f64 = 255.0;

/// The voxels that were tested.
#[derive(Debug)]
pub(crate) struct FreeVoxels {
    known: Vec<u64>,
    /// Those that the world fills.
    pub filled: Vec<u64>,
    /// Those of which it leaves a part free.
    pub partial: Vec<u64>,
    /// The free parts of partial voxels: lowest and highest corner, rounded outward.
    parts: Vec<[[u8; 3]; 2]>,
}

impl FreeVoxels {
    /// No voxels, with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            known: vec![0; COLUMNS_MAX],
            filled: vec![0; COLUMNS_MAX],
            partial: vec![0; COLUMNS_MAX],
            parts: vec![[[0; 3]; 2]; COLUMNS_MAX * LEVELS],
        }
    }

    /// Forgets all voxels.
    pub fn clear(&mut self, grid: &Grid) {
        for voxels in [&mut self.known, &mut self.filled, &mut self.partial] {
            voxels[..grid.columns()].fill(0);
        }
    }

    /// Tests voxels of a column for points farther than `reach` (m) from the world. Returns those
    /// that have some, and the number of those that were not known.
    pub fn test(
        &mut self,
        grid: &Grid,
        collision: &CollisionModel,
        (column, voxels): (usize, u64),
        reach: f64,
    ) -> (u64, u32) {
        if voxels & !self.known[column] != 0 && self.known[column] == 0 {
            self.known[column] = !levels_near_boxes(grid, collision, column, reach);
        }
        let unknown = voxels & !self.known[column];
        for level in levels(unknown) {
            let region = grid.voxels(column, [level, level]);
            match collision.free_part(&region, reach) {
                None => self.filled[column] |= 1 << level,
                Some((_, true)) => {}
                Some((free, false)) => {
                    self.partial[column] |= 1 << level;
                    self.parts[column * LEVELS + level] = stored(&region, &free);
                }
            }
        }
        self.known[column] |= unknown;
        (voxels & !self.filled[column], unknown.count_ones())
    }

    /// The voxels of a second column that are near some of a first one: at most `reach` levels
    /// higher or lower, and their free parts at most `distance_max` (m) apart. Whole voxels beside
    /// each other are near.
    pub fn near(
        &self,
        grid: &Grid,
        [(column, from), (other, to)]: [(usize, u64); 2],
        (reach, distance_max): (u32, f64),
    ) -> u64 {
        let at_once = if reach == 1 {
            spread(from & !self.partial[column], 1) & to & !self.partial[other]
        } else {
            0
        };
        let is_near = |level: &usize| {
            let part = self.part(grid, (other, *level));
            let mut around = levels(spread(1 << level, reach) & from);
            around.any(|level| distance(&part, &self.part(grid, (column, level))) <= distance_max)
        };
        levels(to & !at_once).filter(is_near).fold(at_once, |near, level| near | 1 << level)
    }

    /// The part of a voxel that may be free.
    pub fn part(&self, grid: &Grid, (column, level): (usize, usize)) -> Aabb {
        let region = grid.voxels(column, [level, level]);
        if self.partial[column] >> level & 1 == 0 {
            return region;
        }
        let [low, high] = self.parts[column * LEVELS + level];
        let step = (region.max - region.min) / FINENESS;
        let at = |place: [u8; 3]| region.min + step * DVec3::from(place.map(f64::from));
        Aabb { min: at(low), max: at(high) }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        [&self.known, &self.filled, &self.partial]
            .iter()
            .map(|voxels| size_of_val(voxels.as_slice()))
            .sum::<usize>()
            + size_of_val(self.parts.as_slice())
    }
}

/// The levels of a column that are within `reach` (m) of the bounding box of a shape.
fn levels_near_boxes(grid: &Grid, collision: &CollisionModel, column: usize, reach: f64) -> u64 {
    let place = grid.voxels(column, [0, LEVELS - 1]).grown(reach);
    let mut near = 0;
    collision.for_each_box(&place, |bounds| {
        near |= grid.levels_in(bounds.min.z - reach, bounds.max.z + reach);
    });
    near
}

fn stored(region: &Aabb, free: &Aabb) -> [[u8; 3]; 2] {
    let step = (region.max - region.min) / FINENESS;
    let low = ((free.min - region.min) / step).to_array();
    let high = ((free.max - region.min) / step).to_array();
    // A conversion to u8 saturates.
    [low.map(|value| libm::floor(value) as u8), high.map(|value| libm::ceil(value) as u8)]
}

/// The distance of two boxes, m.
pub(crate) fn distance(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}
