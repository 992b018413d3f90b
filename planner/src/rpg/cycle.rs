//! The cycle of stage M, figure 4.13 of [Grey 4.4] as a machine: the cheapest sequence of
//! transitions, configurations for these, motions within their modes, and back.
//!
//! ```text
//! Sequence(Find) -> Sample -> Move -> complete
//!    ^                |         |
//!    |<-- no luck ----'         v
//!    |              Sequence(Join) -> Move -> complete
//!    |                                  |
//!    '<----------- no luck -------------'
//! ```
//!
//! A sequence that [`Objective::Feasible`] has found is the first whose modes are searched. Where
//! one of its motions is missing, [`Objective::ConnectModes`] chooses the modes to search next
//! among all transitions that have a configuration, by what the modes have cost so far
//! [Grey 4.4.3], and there the trees grow on.

use crate::motion::mode_graph::ArenaFull;
use crate::motion::search_batch::{BatchStats, SEGMENT_SEARCHES_MAX};
use crate::motion::transition_sequence::Objective;
use crate::rpg::lanes::{Lane, Turn};
use crate::rpg::{Phase, Planner};

impl Planner {
    /// Samples configurations for the transitions of all sequences that need some.
    pub(crate) fn sample(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        if !self.round.is_running() {
            self.round.begin();
            for (index, lane) in self.lanes.going() {
                if let Turn::Sample { next, failed } = lane.turn {
                    let next = self.round.add_sampling(
                        index,
                        &self.roadmap,
                        self.cuts.segment(lane),
                        next,
                    );
                    lane.turn = Turn::Sample { next, failed };
                }
            }
        }
        let Some(round) = self.advance_round(budget)? else { return Ok(Phase::Sample) };
        self.tally.transitions_found += u64::from(round.found);
        for index in 0..SEGMENT_SEARCHES_MAX {
            self.lanes.go_to(index);
            self.after_sampling(round.failures[index] > 0)?;
        }
        self.next_turn()
    }

    /// The current lane's turn after a round in which, perhaps, one of its searches `has_failed`.
    fn after_sampling(&mut self, has_failed: bool) -> Result<(), ArenaFull> {
        let Lane { turn: Turn::Sample { next, failed }, ref sequence, objective, .. } =
            *self.lanes.current()
        else {
            return Ok(());
        };
        match (failed || has_failed, objective) {
            (failed, _) if next < sequence.len() => self.take_turn(Turn::Sample { next, failed }),
            (false, _) => self.take_turn(Turn::Move { next: 0, failed: false }),
            (true, Objective::FewerSteps) => self.shorten()?,
            (true, Objective::Feasible | Objective::FromGoal | Objective::ConnectModes) => {
                self.take_turn(Turn::Fail)
            }
        }
        Ok(())
    }

    /// Plans the motions along all sequences whose transitions are found.
    pub(crate) fn plan_motions(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        if !self.round.is_running() {
            self.round.begin();
            for (index, lane) in self.lanes.going() {
                if let Turn::Move { next, failed } = lane.turn {
                    let next = self.round.add_motions(
                        index,
                        &self.shared,
                        &mut self.roadmap,
                        self.cuts.segment(lane),
                        next,
                    );
                    lane.turn = Turn::Move { next, failed };
                }
            }
        }
        let Some(round) = self.advance_round(budget)? else { return Ok(Phase::Move) };
        self.tally.motions_found += u64::from(round.found);
        for index in 0..SEGMENT_SEARCHES_MAX {
            self.lanes.go_to(index);
            self.after_moving(round.failures[index] > 0)?;
        }
        self.next_turn()
    }

    /// The same after a round of motions.
    fn after_moving(&mut self, has_failed: bool) -> Result<(), ArenaFull> {
        let Lane { turn: Turn::Move { next, failed }, ref sequence, objective, .. } =
            *self.lanes.current()
        else {
            return Ok(());
        };
        match (failed || has_failed, objective) {
            (failed, _) if next <= sequence.len() => self.take_turn(Turn::Move { next, failed }),
            (false, _) => self.shorten_or_complete()?,
            (true, Objective::Feasible) => self.seek(Objective::ConnectModes),
            (true, Objective::FromGoal | Objective::ConnectModes) => self.take_turn(Turn::Fail),
            (true, Objective::FewerSteps) => self.shorten()?,
        }
        Ok(())
    }

    /// Advances the round as far as a budget allows; answers what it did once all its searches have
    /// ended.
    pub(crate) fn advance_round(&mut self, budget: u64) -> Result<Option<BatchStats>, ArenaFull> {
        let spent = self.round.advance(&self.shared, &self.roadmap, budget);
        self.tally.work += spent;
        if spent == budget {
            return Ok(None);
        }
        self.tally.work += 1;
        let round = self.round.merge(&self.shared.threads, &mut self.roadmap)?;
        self.tally.segments_at_once = self.tally.segments_at_once.max(round.segment_searches);
        for (total, count) in self.tally.rejections.iter_mut().zip(round.rejections) {
            *total += count;
        }
        Ok(Some(round))
    }
}
