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
    /// Centres of the discs; without any, F is the whole rectangle.
    centres: Vec<DVec2>,
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
            centres: reserve(POINTS_MAX),
            disc_radius: 0.0,
            bounds: [DVec2::ZERO; 2],
            height: 0.0,
            draws: 0,
        }
    }

    /// A rectangle of level ground at a height (m).
    pub fn set_rectangle(&mut self, bounds: [DVec2; 2], height: f64) {
        self.centres.clear();
        (self.bounds, self.height) = (bounds, height);
    }

    /// The discs of this radius (m) about some points, on level ground at a height (m).
    pub fn set_discs(
        &mut self,
        centres: impl Iterator<Item = DVec2>,
        disc_radius: f64,
        height: f64,
    ) {
        self.centres.clear();
        self.centres.extend(centres);
        self.disc_radius = disc_radius;
        self.height = height;
        let around = |[low, high]: [DVec2; 2], centre: &DVec2| {
            [low.min(centre - disc_radius), high.max(centre + disc_radius)]
        };
        self.bounds = self.centres.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], around);
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
        let radius_squared = self.disc_radius * self.disc_radius;
        self.centres.is_empty()
            || self.centres.iter().any(|centre| centre.distance_squared(at) <= radius_squared)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.centres.capacity() * size_of::<DVec2>()
    }
}
