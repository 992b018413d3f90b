//! Removing needless steps: once a segment is complete, the transition search is done again over
//! the placements that it uses, this time for fewer and moderate steps [Grey 4.4.6]. What does not
//! come together leaves the segment as it was.

use crate::motion::mode_graph::ArenaFull;
use crate::motion::transition_sequence::Objective;
use crate::rpg::Planner;
use crate::rpg::lanes::{Lane, Turn};

impl Planner {
    /// After a sequence has all its motions: looks for a shorter one, or completes the segment.
    pub(crate) fn shorten_or_complete(&mut self) -> Result<(), ArenaFull> {
        let Lane { sequence, best, .. } = self.lanes.current_mut();
        best.clear();
        best.extend_from_slice(sequence);
        self.shorten()
    }

    /// Looks for the cheapest sequence over the placements in use, if attempts are left.
    pub(crate) fn shorten(&mut self) -> Result<(), ArenaFull> {
        if self.lanes.current().shortenings < self.shared.constraints.config.step_removal_rounds_max
        {
            self.seek(Objective::FewerSteps);
            return Ok(());
        }
        self.keep_best()
    }

    /// Tries the sequence that was found if it is shorter than the best.
    pub(crate) fn take_shorter(&mut self) -> Result<(), ArenaFull> {
        let lane = self.lanes.current_mut();
        if !self.seeker.search().has_found()
            || self.seeker.search().sequence().len() >= lane.best.len()
        {
            return self.keep_best();
        }
        lane.shortenings += 1;
        self.take_sequence(Turn::Sample { next: 0, failed: false })
    }

    fn keep_best(&mut self) -> Result<(), ArenaFull> {
        let Lane { sequence, best, shortenings, .. } = self.lanes.current_mut();
        *shortenings = 0;
        std::mem::swap(sequence, best);
        self.complete_segment()
    }
}
