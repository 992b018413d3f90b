//! Placements of both feet, uniform over the discs about a route or over the world [Grey 5.3].

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::methods::exploration::POINTS_MAX;
use crate::methods::placements::foothold_at;
use crate::methods::workbench::Workbench;

/// Points of the plane that one unit of work draws at most.
const DRAWS_PER_UNIT: u32 = 64;

/// The set F in which placements are sampled.
#[derive(Debug)]
pub(crate) struct SamplingArea {
    /// The route, whose points are the centres of the discs, m; without it, F is the whole
    /// rectangle.
    route: Vec<DVec2>,
    disc_radius: f64,
    /// The rectangle around F, m.
    bounds: [DVec2; 2],
    /// Height of the ground, m.
    height: f64,
    draws: u64,
}

impl SamplingArea {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            route: reserve(POINTS_MAX),
            disc_radius: 0.0,
            bounds: [DVec2::ZERO; 2],
            height: 0.0,
            draws: 0,
        }
    }

    /// A rectangle of level ground at a height (m).
    pub fn set_rectangle(&mut self, bounds: [DVec2; 2], height: f64) {
        self.route.clear();
        (self.bounds, self.height) = (bounds, height);
    }

    /// The discs of this radius (m) about all points of a route, on level ground at a height (m).
    pub fn set_discs(&mut self, route: impl Iterator<Item = DVec2>, disc_radius: f64, height: f64) {
        self.route.clear();
        self.route.extend(route);
        self.disc_radius = disc_radius;
        self.height = height;
        let around = |[low, high]: [DVec2; 2], centre: &DVec2| {
            [low.min(centre - disc_radius), high.max(centre + disc_radius)]
        };
        self.bounds = self.route.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], around);
    }

    /// Samples a placement of a foot, and adds it if the sole has support and the foot is free.
    /// Returns whether a point of F was drawn: placements without support count, too.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn sample(&mut self, bench: &mut Workbench<'_>, limb: usize) -> Result<bool, ArenaFull> {
        bench.counts.placements += 1;
        for _ in 0..DRAWS_PER_UNIT {
            let mut random = Random::new(bench.context.seed, Stream::Method, 1, self.draws);
            self.draws += 1;
            let [low, high] = self.bounds;
            let at = DVec2::new(random.uniform(low.x, high.x), random.uniform(low.y, high.y));
            if !self.contains(at) {
                continue;
            }
            let rotation = rotation_about(DVec3::Z, random.uniform(0.0, TAU));
            let pose = Pose::from_parts(at.extend(self.height), rotation);
            if let Some(foothold) = foothold_at(bench, limb, &pose) {
                bench.roadmap.graph.add_foothold(foothold)?;
            }
            return Ok(true);
        }
        Ok(false)
    }

    fn contains(&self, at: DVec2) -> bool {
        let is_near = |ends: &[DVec2]| distance_to_line([ends[0], ends[1]], at) <= self.disc_radius;
        self.route.is_empty() || self.route.windows(2).any(is_near)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.route.capacity() * size_of::<DVec2>()
    }
}

/// Distance from a line between two points, m.
fn distance_to_line([from, to]: [DVec2; 2], at: DVec2) -> f64 {
    let offset = to - from;
    let share = (at - from).dot(offset) / offset.length_squared().max(f64::MIN_POSITIVE);
    at.distance(from + share.clamp(0.0, 1.0) * offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_a_line_is_that_from_its_nearest_point() {
        let line = [DVec2::new(1.0, 1.0), DVec2::new(4.0, 1.0)];
        let cases = [([2.0, 3.0], 2.0), ([5.0, 1.0], 1.0), ([-2.0, -3.0], 5.0), ([3.0, 1.0], 0.0)];
        for (at, distance) in cases {
            assert!((distance_to_line(line, at.into()) - distance).abs() < 1e-12, "{at:?}");
        }
        assert_eq!(distance_to_line([DVec2::ONE; 2], DVec2::new(1.0, 3.0)), 2.0);
    }
}
