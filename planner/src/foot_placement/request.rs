//! A query for placements near an ideal one, what it returns, and its statistics.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;

use crate::foot_placement::posed_sole::SoleShape;
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::geometry::polygon::area_and_centroid;

/// A query for placements near an ideal one.
#[derive(Clone, Copy)]
pub struct PlacementQuery<'a> {
    /// The sole; its outline has 3 to 16 vertices.
    pub sole: SoleShape<'a>,
    /// Desired pose of the sole in the world. Only the heading of its rotation counts: the ground
    /// decides the tilt.
    pub ideal: Pose,
    /// The largest horizontal distance from the ideal position, m.
    pub reach_xy: f64,
    /// The lowest and highest height relative to the ideal's, m.
    pub reach_z: [f64; 2],
    /// The largest turn away from the ideal heading, rad.
    pub yaw_spread: f64,
    /// The seed of the random streams.
    pub seed: u64,
    /// The number of the sampled object in the random stream.
    pub object: u64,
    /// The number of the attempt at that object in the random stream.
    pub attempt: u64,
    /// How many placements to examine.
    pub limits: SampleLimits,
    /// Whether the foot collides with nothing at a pose of its sole in the world.
    pub is_free: &'a dyn Fn(&Pose) -> bool,
}

/// How many placements to examine, by source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleLimits {
    /// Geometric candidates.
    pub geometric_max: u32,
    /// Random perturbations of the nearest of them.
    pub perturbed_max: u32,
    /// Placements drawn by Algorithm 1, whose own three limits hold as well.
    pub sampled_max: u32,
}

impl Default for SampleLimits {
    fn default() -> Self {
        Self { geometric_max: 256, perturbed_max: 32, sampled_max: 1_000 }
    }
}

/// How a placement was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Read off the geometry.
    Geometric,
    /// A random perturbation of a geometric one.
    Perturbed,
    /// Algorithm 1 [Grey 4.2.2].
    Sampled,
    /// Nested between two faces, on one too steep to hold the sole alone [Grey 4.2.3].
    Nested,
}

impl Source {
    /// Number of sources.
    pub const COUNT: usize = 4;
}

/// A pose at which a sole is supported and the foot is free.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportedSole {
    /// The sole's pose.
    pub world_from_sole: Pose,
    /// Its support.
    pub support: Support,
    /// How it was found.
    pub source: Source,
}

/// Statistics of a query.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlacementStats {
    /// Placements returned, by [`Source`].
    pub found: [u32; Source::COUNT],
    /// Placements examined, by [`Source`].
    pub examined: [u32; Source::COUNT],
    /// Placements rejected, by reason, in the order of [`NoSupport::ALL`].
    pub rejected: [u32; NoSupport::ALL.len()],
    /// Placements with support where the foot collides.
    pub not_free: u32,
    /// Algorithm 1's placements that were out of reach.
    pub out_of_reach: u32,
    /// Algorithm 1's planes that were too steep or without area.
    pub planes_unsuitable: u32,
    /// Features gathered. At `features_max`, farther ones were left out.
    pub features: u32,
    /// Whether the caller stopped the query.
    pub stopped: bool,
}

impl PlacementQuery<'_> {
    /// Whether the ideal position and the reach are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.ideal.is_finite() && self.reach_xy.is_finite()
    }

    /// Whether a pose of the sole is within reach of the ideal.
    pub(crate) fn is_in_reach(&self, world_from_sole: &Pose) -> bool {
        self.is_near(world_from_sole.translation) && self.is_heading(world_from_sole.rotation)
    }

    /// Whether a position of the sole is near enough to the ideal one.
    pub(crate) fn is_near(&self, position: DVec3) -> bool {
        let moved = position - self.ideal.translation;
        moved.truncate().length() <= self.reach_xy + 1e-9
            && (self.reach_z[0] - 1e-9..=self.reach_z[1] + 1e-9).contains(&moved.z)
    }

    /// Whether the heading of a sole's rotation is near enough to the ideal one.
    pub(crate) fn is_heading(&self, world_from_sole: DQuat) -> bool {
        let [heading, ideal] =
            [world_from_sole, self.ideal.rotation].map(|rotation| (rotation * DVec3::X).truncate());
        heading.dot(ideal)
            >= (libm::cos(self.yaw_spread.clamp(0.0, PI)) - 1e-9)
                * heading.length()
                * ideal.length()
    }

    /// The sole's area, m2.
    pub(crate) fn sole_area(&self) -> f64 {
        area_and_centroid(self.sole.outline).0
    }

    /// The centroid of the sole's outline in the sole frame, m.
    pub(crate) fn sole_centroid(&self) -> DVec2 {
        area_and_centroid(self.sole.outline).1
    }

    /// The largest distance of the sole's outline from its frame's origin, m.
    pub(crate) fn sole_radius(&self) -> f64 {
        self.sole.outline.iter().map(|p| p.length()).fold(0.0, f64::max)
    }

    /// The box in the world around all surfaces that matter to this query, with the horizontal
    /// reach scaled by `share`.
    pub(crate) fn region(&self, share: f64) -> Aabb {
        let side = self.reach_xy * share + self.sole_radius();
        let lower =
            self.ideal.translation + DVec3::new(-side, -side, self.reach_z[0] - self.sole_radius());
        let upper =
            self.ideal.translation + DVec3::new(side, side, self.reach_z[1] + self.sole_radius());
        Aabb::new(lower, upper)
    }
}
