//! Where two parts of the ground that no step connects are nearest to each other.

use glam::DVec3;

use crate::foot_placement::{Bearing, Surfaces};
use crate::geometry::bvh::Aabb;
use crate::relaxation::grid::{Grid, LEVELS, levels, spread};
use crate::relaxation::ground::nearest_ground;
use crate::relaxation::obstruction::{BareGround, GroundGap, SteepGround};
use crate::relaxation::step_search::StepSearch;
use crate::relaxation::tuning::COLUMNS_MAX;

/// Points between both sides at which the ground is examined.
const SAMPLES: usize = 9;
/// Rounds in which the nearest points of both sides are sought from each other.
const ROUNDS: usize = 3;
/// How much higher or lower ground may be that is named as too small, m.
const BARE_HEIGHT: f64 = 0.1;
/// Lowest vertical component of the normal of ground that is called too steep: a wall is no ground.
const STEEP_NORMAL_Z_MIN: f64 = 0.2;

/// Two voxels.
#[derive(Debug, Clone, Copy)]
struct VoxelPair {
    voxels: [(usize, usize); 2],
    distance_squared: f64,
}

/// The search for the nearest voxels of two parts of the ground: all pairs of their edges.
#[derive(Debug)]
pub(crate) struct GapSearch {
    /// The columns at the edges of the part of the start.
    edges: Vec<u32>,
    nearest: Option<VoxelPair>,
}

impl GapSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self { edges: Vec::with_capacity(COLUMNS_MAX), nearest: None }
    }

    /// Begins at the edges of the ground that is reached from the start.
    pub fn begin(&mut self, grid: &Grid, from: &StepSearch) {
        self.edges.clear();
        let edges = (0..grid.columns()).filter(|&column| from.is_edge(grid, column));
        self.edges.extend(edges.map(|column| column as u32));
        self.nearest = None;
    }

    /// Compares a column of the ground of the goal with the edges of that of the start.
    pub fn compare(&mut self, grid: &Grid, [from, to]: [&StepSearch; 2], column: usize) {
        if !to.is_edge(grid, column) {
            return;
        }
        let there = to.reached[column];
        let place = grid.place(column);
        for &edge in &self.edges {
            let other = grid.place(edge as usize);
            let between =
                |axis: usize| (place[axis].abs_diff(other[axis]) as f64 - 1.0).max(0.0) * grid.cell;
            let across = between(0) * between(0) + between(1) * between(1);
            if self.nearest.is_some_and(|nearest| nearest.distance_squared <= across) {
                continue;
            }
            let here = from.reached[edge as usize];
            let Some((levels, rise)) = nearest_levels(here, there) else { continue };
            let height = (f64::from(rise) - 1.0).max(0.0) * grid.level;
            let distance_squared = across + height * height;
            if self.nearest.is_none_or(|nearest| distance_squared < nearest.distance_squared) {
                let voxels = [(edge as usize, levels[0]), (column, levels[1])];
                self.nearest = Some(VoxelPair { voxels, distance_squared });
            }
        }
    }

    /// The gap between the nearest voxels, measured on the ground itself. `span_max` is the upper
    /// bound of a step, m.
    pub fn gap(&self, grid: &Grid, surfaces: &Surfaces, span_max: f64) -> Option<GroundGap> {
        let [here, there] = self.nearest?.voxels;
        let region = |(column, level): (usize, usize)| grid.voxels(column, [level, level]);
        let mut ends = [here, there].map(|voxel| region(voxel).center());
        for _ in 0..ROUNDS {
            for (side, voxel) in [here, there].into_iter().enumerate() {
                let nearest = nearest_ground(surfaces, &region(voxel), ends[1 - side]);
                ends[side] = nearest.unwrap_or(ends[side]);
            }
        }
        let [from, to] = ends;
        let steep = steep_between(surfaces, from, to);
        let bare = bare_between(surfaces, ends, span_max);
        Some(GroundGap { from, to, span_max, steep, bare })
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.edges.capacity() * size_of::<u32>()
    }
}

/// The levels of two columns that are nearest to each other, and their difference.
fn nearest_levels(here: u64, there: u64) -> Option<([usize; 2], u32)> {
    let rise = (0..LEVELS as u32).find(|&rise| spread(here, rise) & there != 0)?;
    let to = (spread(here, rise) & there).trailing_zeros() as usize;
    let from = levels(here).min_by_key(|level| level.abs_diff(to))?;
    Some(([from, to], rise))
}

/// The ground on which no sole rests that is nearest to the first of two points, and on the way to
/// the second or up to `aside` (m) beside it.
fn bare_between(surfaces: &Surfaces, [from, to]: [DVec3; 2], aside: f64) -> Option<BareGround> {
    let mut nearest: Option<(f64, BareGround)> = None;
    let beside = DVec3::new(aside, aside, BARE_HEIGHT);
    let between = Aabb::of_points([from, to]);
    let region = Aabb { min: between.min - beside, max: between.max + beside };
    surfaces.for_each_in(&region, |id| {
        let at = surfaces.nearest_point(id, from.truncate());
        let distance = at.distance(from);
        let is_between = (at - from).dot(to - from) > 0.0 && (at - to).dot(from - to) > 0.0;
        if is_between
            && nearest.is_none_or(|(known, _)| distance < known)
            && let Some([sole_length, spacing]) = Bearing::of(surfaces).spacing_beside(id)
        {
            nearest = Some((distance, BareGround { at: at.truncate(), sole_length, spacing }));
        }
    });
    nearest.map(|(_, bare)| bare)
}

/// The least steep of the ground between two points that is too steep to stand on.
fn steep_between(surfaces: &Surfaces, from: DVec3, to: DVec3) -> Option<SteepGround> {
    let heights = [from.z.min(to.z), from.z.max(to.z)];
    let mut flattest: Option<f64> = None;
    for sample in 1..=SAMPLES {
        let at = from.lerp(to, sample as f64 / (SAMPLES + 1) as f64);
        let region = Aabb { min: at.with_z(heights[0]), max: at.with_z(heights[1]) };
        surfaces.for_each_in(&region, |id| {
            let normal_z = surfaces.normal_z(id);
            let is_steep = normal_z > STEEP_NORMAL_Z_MIN && !surfaces.may_carry(id);
            if is_steep && surfaces.distance_and_height(id, at.truncate()).0 <= 0.0 {
                flattest = Some(flattest.map_or(normal_z, |known| known.max(normal_z)));
            }
        });
    }
    let limit = libm::acos(surfaces.steepest_cos.min(1.0));
    flattest.map(|normal_z| SteepGround { angle: libm::acos(normal_z.min(1.0)), limit })
}
