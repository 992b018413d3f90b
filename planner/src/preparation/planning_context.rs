//! Read-only data of a search.

use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::constraints::tuning::COM_MARGIN_RESERVE;
use crate::foot_placement::{LeastSupport, Surfaces};
use crate::preparation::data::Preparation;

/// Share of the effort that the checker allows which a search with the least margins uses.
const CHECKED_EFFORT_SHARE: f64 = 0.98;

/// What every stage reads and none changes: robot, world, preparation, threads, seed.
#[derive(Debug)]
pub struct PlanningContext {
    /// The robot, the world's geometry and the conditions of every configuration.
    pub constraints: Constraints,
    /// The surfaces on which soles can rest.
    pub surfaces: Surfaces,
    /// The preparation of the robot.
    pub preparation: Preparation,
    /// The threads that share the work.
    pub threads: Threads,
    /// The seed of all random streams.
    pub seed: u64,
    /// The margins of a search that has failed with the configured ones.
    pub(crate) least_margins: LeastMargins,
}

/// Margins that are little larger than those of the checker.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeastMargins {
    /// Distance of the centre of mass from the edge of the support, m.
    com_margin: f64,
    /// The joint efforts, relative to those of the configured margin.
    effort_factor: f64,
    pub support: LeastSupport,
}

impl LeastMargins {
    /// The least margins for a checker, none larger than configured.
    pub fn new(planner: &PlannerConfig, checker: &CheckerConfig) -> Self {
        Self {
            com_margin: planner.com_margin.min(checker.com_margin + COM_MARGIN_RESERVE),
            effort_factor: (CHECKED_EFFORT_SHARE * checker.effort_share / planner.effort_share)
                .max(1.0),
            support: LeastSupport::of(checker, COM_MARGIN_RESERVE),
        }
    }
}

impl PlanningContext {
    /// Relaxes the margins of balance, effort and support to the least ones, for the rest of the
    /// search, and tries more shares of the weight in double support.
    pub(crate) fn relax_margins(&mut self) {
        let LeastMargins { com_margin, effort_factor, support } = self.least_margins;
        self.constraints.relax(com_margin, effort_factor);
        self.surfaces.relax(support);
    }
}
