//! Placements near an ideal one: geometry first, then small perturbations of it, then Algorithm 1.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::{DQuat, DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::random::{Random, Stream};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::support::SupportRequirement;
use crate::foot_placement::surfaces::Surfaces;
use crate::geometry::polygon::area_and_centroid;

/// Candidates that are perturbed at random.
const PERTURBED_MAX: usize = 8;
/// The largest shift of a perturbed candidate in its plane, m, and its largest turn, rad.
const PERTURBATION: (f64, f64) = (0.04, 0.2);
/// Candidates as alike as this (m, and sine of half the turn) are examined once.
const ALIKE: f64 = 1e-3;
/// The reach is searched in boxes that double in size until enough features are found.
const GATHERING_STEPS: i32 = 4;

/// A query for placements near an ideal one.
#[derive(Clone, Copy)]
pub struct PlacementQuery<'a> {
    /// The sole's outline in the sole frame: convex, counter-clockwise, 3 to 16 vertices, m.
    pub sole_polygon: &'a [DVec2],
    /// Desired pose of the sole. Of its rotation only the heading counts: the ground decides
    /// the tilt.
    pub ideal: Pose,
    /// The farthest horizontal distance from the ideal position, m.
    pub reach_xy: f64,
    /// The lowest and highest height relative to the ideal's, m.
    pub reach_z: [f64; 2],
    /// The largest turn away from the ideal heading, rad.
    pub yaw_spread: f64,
    /// The seed of the random streams.
    pub seed: u64,
    /// What is being sampled, for the random stream.
    pub object: u64,
    /// Which attempt at it this is, for the random stream.
    pub attempt: u64,
    /// How many placements to examine.
    pub limits: SampleLimits,
    /// Whether the foot collides with nothing at a pose of its sole.
    pub is_free: &'a dyn Fn(&Pose) -> bool,
}

/// How many placements to examine, by source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleLimits {
    /// Geometric candidates.
    pub geometric_max: u32,
    /// Random perturbations of the nearest of them.
    pub perturbed_max: u32,
    /// Placements drawn by Algorithm 1 (its own three limits hold besides).
    pub sampled_max: u32,
}

impl Default for SampleLimits {
    fn default() -> Self {
        Self { geometric_max: 256, perturbed_max: 32, sampled_max: 1_000 }
    }
}

/// Where a placement came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Read off the geometry.
    Geometric,
    /// A random perturbation of a geometric one.
    Perturbed,
    /// Algorithm 1 [Grey 4.2.2].
    Sampled,
    /// Nested in a concave place, on a face too steep to hold the sole alone [Grey 4.2.3].
    Nested,
}

impl Source {
    /// How many sources there are.
    pub const COUNT: usize = 4;
}

/// A pose at which a sole is carried and the foot is free.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportedSole {
    /// The sole's pose.
    pub world_from_sole: Pose,
    /// What carries it.
    pub support: Support,
    /// Where it came from.
    pub source: Source,
}

/// Statistics of a query.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlacementStats {
    /// Placements handed out, by [`Source`].
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
    /// Features gathered; `features_max` of them means that farther ones were left out.
    pub features: u32,
    /// Whether the caller stopped the query.
    pub stopped: bool,
}

impl PlacementQuery<'_> {
    /// Whether a pose of the sole is within reach of the ideal.
    pub(crate) fn reaches(&self, world_from_sole: &Pose) -> bool {
        self.is_near(world_from_sole.translation) && self.heads(world_from_sole.rotation)
    }

    /// Whether a position of the sole is near enough to the ideal one.
    pub(crate) fn is_near(&self, position: DVec3) -> bool {
        let moved = position - self.ideal.translation;
        moved.truncate().length() <= self.reach_xy + 1e-9
            && (self.reach_z[0] - 1e-9..=self.reach_z[1] + 1e-9).contains(&moved.z)
    }

    /// Whether a rotation of the sole heads near enough to where the ideal one does.
    pub(crate) fn heads(&self, world_from_sole: DQuat) -> bool {
        let [heading, ideal] =
            [world_from_sole, self.ideal.rotation].map(|rotation| (rotation * DVec3::X).truncate());
        heading.dot(ideal)
            >= (libm::cos(self.yaw_spread.clamp(0.0, PI)) - 1e-9)
                * heading.length()
                * ideal.length()
    }

    /// The sole's area, m2.
    pub(crate) fn sole_area(&self) -> f64 {
        area_and_centroid(self.sole_polygon).0
    }

    /// The largest distance of the sole's outline from its frame's origin, m.
    pub(crate) fn sole_radius(&self) -> f64 {
        self.sole_polygon.iter().map(|p| p.length()).fold(0.0, f64::max)
    }

    /// The box in the world where surfaces may be for this query, its horizontal size scaled by
    /// `share`.
    pub(crate) fn region(&self, share: f64) -> Aabb {
        let side = self.reach_xy * share + self.sole_radius();
        let lower =
            self.ideal.translation + DVec3::new(-side, -side, self.reach_z[0] - self.sole_radius());
        let upper =
            self.ideal.translation + DVec3::new(side, side, self.reach_z[1] + self.sole_radius());
        Aabb::new(lower, upper)
    }
}

/// A query in progress.
pub(crate) struct Proposal<'a, 'r> {
    pub surfaces: &'a Surfaces,
    pub scratch: &'a mut Scratch,
    pub query: &'a PlacementQuery<'r>,
    pub random: Random,
    pub stats: PlacementStats,
    pub out: &'a mut dyn FnMut(SupportedSole) -> bool,
}

impl Surfaces {
    /// Hands placements within reach to `out`, best first, until it returns `false` or the limits
    /// is spent. The order depends on nothing but the arguments. An ideal that is not finite finds
    /// nothing.
    pub fn propose(
        &self,
        scratch: &mut Scratch,
        query: &PlacementQuery,
        out: &mut dyn FnMut(SupportedSole) -> bool,
    ) -> PlacementStats {
        let random = Random::new(query.seed, Stream::FootPlacement, query.object, query.attempt);
        let mut proposal = Proposal {
            surfaces: self,
            scratch,
            query,
            random,
            stats: PlacementStats::default(),
            out,
        };
        if query.ideal.is_finite() && query.reach_xy.is_finite() {
            let outcome = proposal.run();
            proposal.stats.stopped = outcome.is_break();
        }
        proposal.stats
    }

    /// Lists the nearest features within reach that may carry, nearest first.
    pub(crate) fn gather(&self, scratch: &mut Scratch, query: &PlacementQuery) {
        for step in (0..GATHERING_STEPS).rev() {
            scratch.features.clear();
            self.gather_in(scratch, query, &query.region(1.0 / f64::from(1 << step)));
            if scratch.features.len() >= self.config.features_max {
                break;
            }
        }
    }

    fn gather_in(&self, scratch: &mut Scratch, query: &PlacementQuery, region: &Aabb) {
        for (count, id) in self.elements_in(region).enumerate() {
            if count >= self.config.support_elements_max {
                scratch.features.capacity.dropped += 1;
                break;
            }
            if !self.may_carry(id) {
                continue;
            }
            self.list_feature(scratch, query, id);
        }
        keep_nearest(scratch, self.config.features_max);
    }

    /// Lists a feature by its distance from the ideal; of too many only the nearest stay.
    pub(crate) fn list_feature(&self, scratch: &mut Scratch, query: &PlacementQuery, id: u32) {
        if scratch.features.is_full() {
            keep_nearest(scratch, self.config.features_max);
        }
        let ideal = query.ideal.translation;
        let (aside, height) = self.distance_and_height(id, ideal.truncate());
        scratch.features.push((aside + (height - ideal.z).abs(), id));
    }
}

pub(crate) fn keep_nearest(scratch: &mut Scratch, count: usize) {
    scratch.features.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    scratch.features.truncate(count);
}

impl Proposal<'_, '_> {
    fn run(&mut self) -> ControlFlow<()> {
        self.surfaces.gather(self.scratch, self.query);
        self.stats.features = self.scratch.features.len() as u32;
        let is_rough = self.is_rough();
        if is_rough {
            self.propose_on_rough_ground()?;
        }
        self.surfaces.begin_candidates(self.scratch, self.query);
        self.propose_geometric()?;
        if !is_rough && self.stats.found == [0; Source::COUNT] {
            self.propose_on_rough_ground()?;
        }
        self.propose_perturbed()?;
        self.sample()
    }

    /// The geometric candidates: first those that carry much, then those that carry enough.
    fn propose_geometric(&mut self) -> ControlFlow<()> {
        self.scratch.deferred.clear();
        let requirement = self.requirement(1.0);
        let mut count = 0;
        while count < self.query.limits.geometric_max
            && self.surfaces.next_candidate(self.scratch, self.query)
        {
            let last = self.scratch.candidates.len() - 1;
            if self.is_repeated(last) {
                continue;
            }
            count += 1;
            let examined = self.examine(
                self.scratch.candidates[last].world_from_sole,
                Source::Geometric,
                requirement,
            )?;
            if examined == Examined::Rejected(NoSupport::AreaTooSmall)
                && requirement.area_min > self.requirement(0.0).area_min
            {
                self.scratch.deferred.push(last as u32);
            }
        }
        for i in 0..self.scratch.deferred.len() {
            let pose = self.scratch.candidates[self.scratch.deferred[i] as usize].world_from_sole;
            self.examine(pose, Source::Geometric, self.requirement(0.0))?;
        }
        ControlFlow::Continue(())
    }

    /// The requirement with this share of the inflation of the area's bound, from 1 to 0
    /// [Grey 4.1.2].
    pub(crate) fn requirement(&self, share: f64) -> SupportRequirement {
        let config = &self.surfaces.config;
        let area_min =
            config.support_area_min * (1.0 + (config.support_area_inflation - 1.0) * share);
        SupportRequirement { area_min, is_braced: false, any_intrusion: true }
    }

    /// Whether a candidate is like one just before it; costs are sorted, so that is where its like
    /// are.
    fn is_repeated(&self, index: usize) -> bool {
        let at = &self.scratch.candidates[index];
        let is_alike = |pose: &Pose| {
            let turn = (pose.rotation.conjugate() * at.world_from_sole.rotation).xyz().length();
            (pose.translation - at.world_from_sole.translation).length() < ALIKE && turn < ALIKE
        };
        let before = self.scratch.candidates[..index].iter().rev();
        before.take_while(|c| at.cost - c.cost < 2.0 * ALIKE).any(|c| is_alike(&c.world_from_sole))
    }

    fn propose_perturbed(&mut self) -> ControlFlow<()> {
        let count = self.scratch.candidates.len().min(PERTURBED_MAX);
        for i in 0..self.query.limits.perturbed_max as usize {
            if count == 0 {
                break;
            }
            let base = self.scratch.candidates[i % count].world_from_sole;
            let (shift, turn) = PERTURBATION;
            let shift = DVec3::new(
                self.random.uniform(-shift, shift),
                self.random.uniform(-shift, shift),
                0.0,
            );
            let turn = rotation_about(DVec3::Z, self.random.uniform(-turn, turn));
            let pose = base * Pose::from_parts(shift, turn);
            if self.query.reaches(&pose) {
                self.examine(pose, Source::Perturbed, self.requirement(0.0))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Hands a placement out if the sole is supported and the foot free there. Returns whether it
    /// was, or breaks if the caller stops the query.
    pub(crate) fn examine(
        &mut self,
        world_from_sole: Pose,
        source: Source,
        requirement: SupportRequirement,
    ) -> ControlFlow<(), Examined> {
        self.stats.examined[source as usize] += 1;
        let support = match self.surfaces.support_of(
            self.scratch,
            self.query.sole_polygon,
            &world_from_sole,
            requirement,
        ) {
            Ok(support) => support,
            Err(reason) => {
                self.stats.rejected[reason as usize] += 1;
                return ControlFlow::Continue(Examined::Rejected(reason));
            }
        };
        self.hand_out(world_from_sole, support, source)
    }

    /// Hands out a carried sole if the foot is free there.
    pub(crate) fn hand_out(
        &mut self,
        world_from_sole: Pose,
        support: Support,
        source: Source,
    ) -> ControlFlow<(), Examined> {
        if !(self.query.is_free)(&world_from_sole) {
            self.stats.not_free += 1;
            return ControlFlow::Continue(Examined::NotFree);
        }
        self.stats.found[source as usize] += 1;
        if (self.out)(SupportedSole { world_from_sole, support, source }) {
            ControlFlow::Continue(Examined::Found)
        } else {
            ControlFlow::Break(())
        }
    }
}

/// What became of a placement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Examined {
    /// Handed out.
    Found,
    /// The foot collides there.
    NotFree,
    /// The sole is not carried there.
    Rejected(NoSupport),
}
