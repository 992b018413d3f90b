//! Transitions between the placements, and how likely each is [Grey 4.4.2].

use rayon::prelude::*;

use super::{Phase, Planner};
use crate::motion::foothold::{Foothold, left_and_right};
use crate::motion::graph::{ArenaFull, FootholdId, Graph, Prior, TransitionId};
use crate::seeding::{Seeding, judge};

/// Transitions that are judged side by side.
const JUDGED_AT_ONCE: usize = 32;

impl Planner {
    /// Connects the next placement with its neighbours; once all are, counts it to the nearest station.
    pub(super) fn connect(&mut self, next: FootholdId) -> Result<Phase, ArenaFull> {
        if next as usize == self.roadmap.graph.footholds().len() {
            return if self.locate_next() { Ok(Phase::Connect { next }) } else { self.after_connecting() };
        }
        let seeding = Seeding::of(&self.shared);
        let steps = self.shared.preparation.possible_steps();
        let (stretches, was_connected) = (self.stretches, next < self.roadmap.graph.connected());
        let is_due = |a: &Foothold, b: &Foothold| {
            let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
            if steps.may_step(soles) { !was_connected } else { stretches }
        };
        seeding.connect(next, steps.reach(), &is_due, &mut self.roadmap.graph)?;
        self.roadmap.graph.mark_connected(next);
        Ok(Phase::Connect { next: next + 1 })
    }

    /// Connects placements, too, that are farther apart than primitive postures reach: they burden the search, so only where the others
    /// lead nowhere.
    pub(super) fn stretch(&mut self) -> Phase {
        self.stretches = true;
        Phase::Connect { next: 0 }
    }

    /// Judges how likely the next transitions are, each with its twin one unit of work; then looks for a sequence again. What is not
    /// judged yet costs as little as it can, so the cheapest sequence is the cheapest of all once all that it holds is judged.
    pub(super) fn judge(&mut self, budget: u64) -> Phase {
        let next = self.next_to_judge(budget);
        if next.is_empty() {
            self.tally.work += 1;
            return Phase::Sequence { begun: false };
        }
        let mut priors = [[Prior::default(); 2]; JUDGED_AT_ONCE];
        let may_be_scant = self.tally.routes > 1 || self.tally.sweeps > 1;
        let (constraints, graph) = (&self.shared.constraints, &mut self.roadmap.graph);
        let judge_both = |(&id, priors): (&TransitionId, &mut [Prior; 2])| {
            *priors = [id, Graph::twin(id)].map(|id| judge(constraints, id, graph, may_be_scant));
        };
        if self.shared.parallel {
            next.par_iter().zip(&mut priors).with_max_len(1).for_each(judge_both);
        } else {
            next.iter().zip(&mut priors).for_each(judge_both);
        }
        for (&id, [prior, twin_prior]) in next.iter().zip(priors) {
            graph.record_prior(id, prior);
            graph.record_prior(Graph::twin(id), twin_prior);
        }
        self.tally.work += next.len() as u64;
        Phase::Judge
    }

    /// The next transitions to judge, as many as a budget allows, one of each pair of twins: those of the sequence found last, then all
    /// on the placements of those that turn out to be unlikely, since the next sequence would only go through the next of these.
    fn next_to_judge(&self, budget: u64) -> heapless::Vec<TransitionId, JUDGED_AT_ONCE> {
        let (graph, sequence) = (&self.roadmap.graph, self.search.sequence());
        let unlikely = sequence.iter().filter(|&&id| graph.is_unlikely(id)).flat_map(|&id| [id, Graph::twin(id)]);
        let neighbours = unlikely.flat_map(|id| graph.from_stance(graph.transitions()[id as usize].stance));
        let mut next = heapless::Vec::new();
        for id in sequence.iter().copied().chain(neighbours).filter(|&id| graph.is_unjudged(id)).map(|id| id.min(Graph::twin(id))) {
            if !next.contains(&id) && (next.len() as u64 == budget || next.push(id).is_err()) {
                break;
            }
        }
        next
    }
}
