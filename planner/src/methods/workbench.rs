//! What the methods work with: the context, Gamma_M, and counted work.

use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::{Foothold, left_and_right};
use crate::constraints::rejection::Rejection;
use crate::foot_placement::Scratch;
use crate::motion::roadmap::Roadmap;
use crate::motion::search_batch::{BatchStats, SearchBatch};
use crate::preparation::planning_context::PlanningContext;

/// The data of a search that a method reads and changes.
#[derive(Debug)]
pub(crate) struct Workbench<'a> {
    /// Robot, world, preparation, threads, seed.
    pub context: &'a PlanningContext,
    /// Gamma_M, with the boundaries at start and goal.
    pub roadmap: &'a mut Roadmap,
    /// Searches for configurations and motions that run in parallel.
    pub batch: &'a mut SearchBatch,
    /// Memory of foot placement queries.
    pub scratch: &'a mut Scratch,
    /// The counts of this step.
    pub counts: MethodCounts,
}

/// Counts of one step of a method: work units by their kind, and what they found.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MethodCounts {
    /// Work on a route.
    pub route: u64,
    /// Work on placements.
    pub placements: u64,
    /// Work on transitions between them.
    pub transitions: u64,
    /// Work on sequences.
    pub sequence: u64,
    /// Work on configurations.
    pub configurations: u64,
    /// Work on motions.
    pub motions: u64,
    /// Sequences tried.
    pub sequences: u64,
    /// Routes handed on.
    pub routes: u64,
    /// Configurations found.
    pub transitions_found: u64,
    /// Motions found.
    pub motions_found: u64,
    /// Rejected configurations and motions.
    pub rejections: [u64; Rejection::COUNT],
}

/// What a step of a method came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MethodEvent {
    /// There is more to do.
    Continue,
    /// The sequence has all its motions.
    Found,
    /// The method cannot express the problem, and why.
    NotExpressible(&'static str),
    /// The method has nothing left to try, and why.
    Exhausted(&'static str),
}

impl MethodCounts {
    /// All work units.
    pub fn work(&self) -> u64 {
        self.route
            + self.placements
            + self.transitions
            + self.sequence
            + self.configurations
            + self.motions
    }
}

impl Workbench<'_> {
    /// The longest level step, m.
    pub fn step_max(&self) -> f64 {
        self.context.preparation.step_limits().longest_level_step()
    }

    /// Whether the step limits allow a step between two footholds, and the feet do not collide.
    pub fn may_step(&self, [stance, landed]: [&Foothold; 2]) -> bool {
        let soles = left_and_right(stance, landed).map(|foothold| &foothold.world_from_sole);
        self.context.preparation.step_limits().may_step(soles)
            && !self.context.constraints.collision.feet_hit(soles)
    }

    /// Advances the batch by at most `budget` units of work. Returns the units spent, and what it
    /// did once all its searches have ended.
    ///
    /// # Errors
    /// An arena is full.
    pub fn advance_batch(&mut self, budget: u64) -> Result<(u64, Option<BatchStats>), ArenaFull> {
        let spent = self.batch.advance(self.context, self.roadmap, budget);
        if spent == budget {
            return Ok((spent, None));
        }
        let stats = self.batch.merge(&self.context.threads, self.roadmap)?;
        for (total, count) in self.counts.rejections.iter_mut().zip(stats.rejections) {
            *total += count;
        }
        Ok((spent + 1, Some(stats)))
    }
}
