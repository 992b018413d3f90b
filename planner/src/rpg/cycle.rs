//! The cycle of stage M, figure 4.13 of [Grey 4.4] as a machine: the cheapest sequence of transitions, configurations for these,
//! motions within their modes, and back.
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
//! A sequence that [`Purpose::Find`] has found is the first whose modes are searched. Where one of its motions is missing,
//! [`Purpose::Join`] chooses the modes to search next among all transitions that have a configuration, by what the modes
//! have cost so far [Grey 4.4.3], and there the trees grow on.

use surefoot_shared_types::message::SupportMode;

use super::{Boundary, Phase, Planner, boundary_node};
use crate::motion::graph::{ArenaFull, TransitionId};
use crate::motion::round::RoundTally;
use crate::motion::sequence::{Purpose, Query};

/// Transitions that a start on one foot leads to at the most; the others are reached through these.
const STARTS_MAX: usize = 256;

impl Planner {
    /// Looks for the cheapest sequence.
    pub(super) fn find_sequence(&mut self, purpose: Purpose, begun: bool, budget: u64) -> Result<Phase, ArenaFull> {
        let [from, to] = match (self.cuts.boundaries(), purpose) {
            ([start, goal], Purpose::Return) => [goal, start],
            (ends, _) => ends,
        };
        if !begun && purpose == Purpose::Join {
            self.roadmap.costs.spread(&self.roadmap.graph, [from, to].map(boundary_node));
        }
        let query = Query {
            graph: &self.roadmap.graph,
            edges: &self.roadmap.edges,
            modes: &self.roadmap.costs,
            purpose,
            stations: &self.nearest_stations,
            range: self.cuts.window(),
            ends: [from, to].map(boundary_node),
            starts: &self.start_transitions(from),
            goal: self.roadmap.boundary(to).footholds,
        };
        if !begun {
            self.search.begin(&query);
        }
        let spent = self.search.advance(&query, budget);
        self.tally.work += spent;
        if spent == budget {
            return Ok(Phase::Sequence { purpose, begun: true });
        }
        self.tally.work += 1;
        self.purpose = purpose;
        self.after_sequence_search()
    }

    fn after_sequence_search(&mut self) -> Result<Phase, ArenaFull> {
        let has_found = self.search.has_found();
        match self.purpose {
            Purpose::Find => {
                self.tally.sequences += 1;
                Ok(if has_found { Phase::Sample { next: 0, failed: false } } else { self.after_no_sequence() })
            }
            Purpose::Return => Ok(self.between_frontiers()),
            Purpose::Join if has_found => Ok(Phase::Move { next: 0, failed: false }),
            Purpose::Join => self.after_failure(),
            Purpose::Shorten => self.take_shorter(has_found),
        }
    }

    /// The transitions that a boundary leads to: on both feet those between its two placements, on one foot all that this one
    /// carries.
    fn start_transitions(&self, boundary: usize) -> heapless::Vec<TransitionId, STARTS_MAX> {
        let Boundary { footholds: [left, right], support, .. } = *self.roadmap.boundary(boundary);
        let graph = &self.roadmap.graph;
        match support {
            SupportMode::Left => graph.from_stance(left).take(STARTS_MAX).collect(),
            SupportMode::Right => graph.from_stance(right).take(STARTS_MAX).collect(),
            SupportMode::Double => [graph.find(left, right), graph.find(right, left)].into_iter().flatten().collect(),
        }
    }

    /// Samples configurations for the transitions of the sequence.
    pub(super) fn sample(&mut self, next: usize, failed: bool, budget: u64) -> Result<Phase, ArenaFull> {
        let segment = self.cuts.segment(self.search.sequence());
        if !self.round.is_running() {
            self.round.begin_sampling(&self.roadmap, segment, next);
        }
        let done_at = segment.sequence.len();
        let Some((round, failed)) = self.advance_round(failed, budget)? else { return Ok(Phase::Sample { next, failed }) };
        self.tally.transitions_found += u64::from(round.found);
        match (failed, self.purpose) {
            _ if round.next < done_at => Ok(Phase::Sample { next: round.next, failed }),
            (false, _) => Ok(Phase::Move { next: 0, failed: false }),
            (true, Purpose::Shorten) => self.shorten(),
            (true, Purpose::Find | Purpose::Return | Purpose::Join) => self.after_failure(),
        }
    }

    /// Plans the motions along the sequence.
    pub(super) fn plan_motions(&mut self, next: usize, failed: bool, budget: u64) -> Result<Phase, ArenaFull> {
        let segment = self.cuts.segment(self.search.sequence());
        if !self.round.is_running() {
            self.round.begin_motions(&self.shared, &mut self.roadmap, segment, next);
        }
        let done_at = segment.sequence.len() + 1;
        let Some((round, failed)) = self.advance_round(failed, budget)? else { return Ok(Phase::Move { next, failed }) };
        self.tally.motions_found += u64::from(round.found);
        match (failed, self.purpose) {
            _ if round.next < done_at => Ok(Phase::Move { next: round.next, failed }),
            (false, _) => self.shorten_or_complete(),
            (true, Purpose::Find) => Ok(Phase::seek(Purpose::Join)),
            (true, Purpose::Return | Purpose::Join) => self.after_failure(),
            (true, Purpose::Shorten) => self.shorten(),
        }
    }

    /// Advances the round as far as a budget allows; answers what it did, and whether any of its searches or, as `failed` says, an
    /// earlier one has failed, once all have ended.
    pub(super) fn advance_round(&mut self, failed: bool, budget: u64) -> Result<Option<(RoundTally, bool)>, ArenaFull> {
        let spent = self.round.advance(&self.shared, &self.roadmap, budget);
        self.tally.work += spent;
        if spent == budget {
            return Ok(None);
        }
        self.tally.work += 1;
        let round = self.round.merge(&mut self.roadmap)?;
        for (total, count) in self.tally.rejections.iter_mut().zip(round.rejections) {
            *total += count;
        }
        let failed = failed || round.failures > 0;
        Ok(Some((round, failed)))
    }
}
