//! A query in progress: the data that the sources of placements share, and the examination of one
//! placement.

use std::ops::ControlFlow;

use surefoot_shared_types::Pose;

use crate::base::random::{Random, Stream};
use crate::foot_placement::posed_sole::SupportRequirement;
use crate::foot_placement::request::{PlacementQuery, PlacementStats, Source, SupportedSole};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::sole_support::{NoSupport, Support};
use crate::foot_placement::surfaces::Surfaces;

/// A query in progress.
pub(crate) struct Proposal<'a, 'r> {
    pub surfaces: &'a Surfaces,
    pub scratch: &'a mut Scratch,
    pub query: &'a PlacementQuery<'r>,
    pub random: Random,
    pub stats: PlacementStats,
    /// Receives each placement found. Returns `false` to stop the query.
    pub out: &'a mut dyn FnMut(SupportedSole) -> bool,
}

/// Result of examining a placement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Examined {
    /// Returned to the caller.
    Found,
    /// The foot collides there.
    NotFree,
    /// The sole is not supported there.
    Rejected(NoSupport),
}

impl<'a, 'r> Proposal<'a, 'r> {
    /// A query about to begin.
    pub fn new(
        surfaces: &'a Surfaces,
        scratch: &'a mut Scratch,
        query: &'a PlacementQuery<'r>,
        out: &'a mut dyn FnMut(SupportedSole) -> bool,
    ) -> Self {
        let random = Random::new(query.seed, Stream::FootPlacement, query.object, query.attempt);
        Self { surfaces, scratch, query, random, stats: PlacementStats::default(), out }
    }

    /// The requirement with this share of the inflation of the area's bound, from 1 to 0
    /// [Grey 4.1.2].
    pub fn requirement(&self, share: f64) -> SupportRequirement {
        let config = self.surfaces.config();
        let area_min =
            config.support_area_min * (1.0 + (config.support_area_inflation - 1.0) * share);
        SupportRequirement { area_min, is_braced: false, any_intrusion: true }
    }

    /// Returns a placement, set down, to the caller if the sole is supported and the foot free
    /// there. Breaks if the caller stops the query.
    pub fn examine(
        &mut self,
        world_from_sole: Pose,
        source: Source,
        requirement: SupportRequirement,
    ) -> ControlFlow<(), Examined> {
        self.stats.examined[source as usize] += 1;
        match self.surfaces.set_down(self.scratch, self.query.sole, &world_from_sole, requirement) {
            Ok((pose, support)) => self.return_if_free(pose, support, source),
            Err(reason) => {
                self.stats.rejected[reason as usize] += 1;
                ControlFlow::Continue(Examined::Rejected(reason))
            }
        }
    }

    /// Returns a supported sole to the caller if the foot is free there.
    pub fn return_if_free(
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
