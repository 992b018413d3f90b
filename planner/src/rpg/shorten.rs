//! Removing needless steps: once a segment is complete, the transition search is done again over the placements that it uses,
//! this time for fewer and moderate steps [Grey 4.4.6]. What does not come together leaves the segment as it was.

use surefoot_shared_types::config::PlannerConfig;

use super::{Phase, Planner, Purpose};
use crate::arena::reserve;
use crate::motion::graph::{ArenaFull, TransitionId};

/// The segment as it was before it is shortened, and what may be spent on that.
#[derive(Debug)]
pub struct Shortening {
    rounds_max: u32,
    /// Rounds begun for this segment; 0 while it is not being shortened.
    rounds: u32,
    best: Vec<TransitionId>,
}

impl Shortening {
    /// Room for any segment.
    pub fn new(config: &PlannerConfig) -> Self {
        Self { rounds_max: config.shorten_rounds_max, rounds: 0, best: reserve(config.configurations_max as usize) }
    }

    /// Keeps a complete sequence; `false` where there is no room for it.
    fn keep(&mut self, sequence: &[TransitionId]) -> bool {
        let fits = sequence.len() <= self.best.capacity();
        if fits {
            self.best.clear();
            self.best.extend_from_slice(sequence);
        }
        fits
    }
}

impl Planner {
    /// After a sequence has all its motions: looks for a shorter one, or completes the segment.
    pub(super) fn shorten_or_complete(&mut self) -> Result<Phase, ArenaFull> {
        if !self.shortening.keep(self.search.sequence()) {
            return self.complete_segment();
        }
        self.search.use_only(&self.roadmap.graph, &self.shortening.best);
        self.shorten()
    }

    /// Looks for the cheapest sequence over the placements in use, if rounds are left.
    pub(super) fn shorten(&mut self) -> Result<Phase, ArenaFull> {
        if self.shortening.rounds < self.shortening.rounds_max {
            return Ok(Phase::seek(Purpose::Shorten));
        }
        self.keep_best()
    }

    /// Tries the sequence that was found if it is shorter than the best.
    pub(super) fn take_shorter(&mut self, has_found: bool) -> Result<Phase, ArenaFull> {
        if has_found && self.search.sequence().len() < self.shortening.best.len() {
            self.shortening.rounds += 1;
            return Ok(Phase::Sample { next: 0, failed: false });
        }
        self.keep_best()
    }

    fn keep_best(&mut self) -> Result<Phase, ArenaFull> {
        self.shortening.rounds = 0;
        self.search.restore(&self.shortening.best);
        self.complete_segment()
    }
}
