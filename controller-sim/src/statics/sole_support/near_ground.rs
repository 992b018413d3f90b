//! The deepest ground near each sample: a foot beside its place may stand on it.

use glam::DVec2;

use crate::statics::sole_support::ray_sample::RaySample;
use crate::statics::tuning::{FINE_SAMPLE_SPACING, STEEP_GROUND_MIN};
use crate::statics::underside::FineGrid;

/// The ground that the rays of a fine grid have found under a sole and beside it.
pub(super) struct NearGround<'a> {
    grid: &'a FineGrid,
    points: Vec<GroundPoint>,
}

/// The ground below a point of the grid.
#[derive(Clone, Copy)]
struct GroundPoint {
    /// Its depth below the sole plane, m: infinite over a void, minus infinity where it does not
    /// count.
    depth: f64,
    /// The growth of the depth along its plane, m per m.
    gradient: DVec2,
    is_carrying: bool,
}

impl<'a> NearGround<'a> {
    /// Ground below the foot that no ray has found is a void. Beside the foot it does not count.
    pub(super) fn new(grid: &'a FineGrid) -> Self {
        let unmeasured = |index| GroundPoint {
            depth: if grid.is_foot(index) { f64::INFINITY } else { f64::NEG_INFINITY },
            gradient: DVec2::ZERO,
            is_carrying: false,
        };
        Self { grid, points: (0..grid.len()).map(unmeasured).collect() }
    }

    /// Leaves out the ground below a point: that of a sample which knows its slope.
    pub(super) fn leave_out(&mut self, index: usize) {
        self.points[index].depth = f64::NEG_INFINITY;
    }

    /// The ground below a point of the grid is that of a sample.
    pub(super) fn set(&mut self, index: usize, sample: &RaySample) {
        let RaySample { gradient, is_carrying, is_round, .. } = *sample;
        // On curved ground as much is missed as on the samples of its crests.
        let gradient = if is_round { DVec2::ZERO } else { gradient };
        self.points[index] = GroundPoint { depth: sample.depth(), gradient, is_carrying };
    }

    /// Lowers the ground below all samples to the deepest that is near. The samples `on_grid` are
    /// those of the points `indices`. A sample also carries if one as near does: the foot touches a
    /// peak from its gentle side.
    pub(super) fn widen(
        &mut self,
        indices: &[usize],
        mut on_grid: Vec<RaySample>,
        mut others: Vec<RaySample>,
    ) -> Vec<RaySample> {
        indices.iter().zip(&on_grid).for_each(|(&index, sample)| self.set(index, sample));
        for (sample, &index) in on_grid.iter_mut().zip(indices) {
            self.grid.within_point(index).for_each(|near| self.take(sample, near));
        }
        for sample in &mut others {
            self.grid.within(sample.point.at).for_each(|near| self.take(sample, near));
            if sample.is_round {
                // As much as on the crests' samples, which lie beside the grid.
                let nearest = self.grid.nearest(sample.point.at);
                self.grid.within_point(nearest).for_each(|near| self.take(sample, near));
            }
        }
        [on_grid, others].concat()
    }

    /// Lowers the ground of a sample to that near it.
    fn take(&self, sample: &mut RaySample, near: usize) {
        let ground = self.points[near];
        let aside = self.grid.at(near) - sample.point.at;
        let deepest = sample.point.height + ground.depth + self.deeper(&ground, aside);
        sample.most_air = sample.most_air.max(deepest);
        sample.is_carrying |= ground.is_carrying && sample.air.is_finite();
    }

    /// How much deeper than in the middle of its cell, which lies `aside` (m) of a sample, ground
    /// is that the foot may still reach, m.
    fn deeper(&self, ground: &GroundPoint, aside: DVec2) -> f64 {
        let slope = ground.gradient.length();
        if !(slope > 0.0 && slope < STEEP_GROUND_MIN && ground.depth.is_finite()) {
            return 0.0;
        }
        let along = aside.dot(ground.gradient) / slope;
        let left = self.grid.reach().powi(2) - aside.length_squared();
        if left <= 0.0 {
            return 0.0;
        }
        let way = -along + (along * along + left).sqrt();
        slope * way.min(0.5 * FINE_SAMPLE_SPACING)
    }
}
