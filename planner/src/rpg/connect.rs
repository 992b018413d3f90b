//! Transitions between the placements, and how likely each is [Grey 4.4.2].

use rayon::prelude::*;

use super::{Phase, Planner};
use crate::motion::graph::{ArenaFull, FootholdId, Graph, Prior, TransitionId};
use crate::seeding::{Seeding, judge};

/// Transitions that are judged side by side.
const JUDGED_AT_ONCE: usize = 32;

impl Planner {
    /// Connects the next placement with its neighbours; once all are, counts it to the nearest station.
    pub(super) fn connect(&mut self, next: FootholdId) -> Result<Phase, ArenaFull> {
        if next as usize == self.roadmap.graph.footholds().len() {
            return Ok(if self.locate_next() { Phase::Connect { next } } else { Phase::Judge });
        }
        let seeding = Seeding { constraints: &self.shared.constraints, surfaces: &self.surfaces, seed: self.scenario.seed };
        seeding.connect(next, self.step_max(), &mut self.roadmap.graph)?;
        self.roadmap.graph.mark_connected(next);
        Ok(Phase::Connect { next: next + 1 })
    }

    /// Judges how likely the next transitions are, each with its twin one unit of work.
    pub(super) fn judge(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        let graph = &mut self.roadmap.graph;
        let longest = budget.min(JUDGED_AT_ONCE as u64) as usize;
        let next: heapless::Vec<TransitionId, JUDGED_AT_ONCE> = std::iter::from_fn(|| graph.next_to_judge()).take(longest).collect();
        if next.is_empty() {
            self.tally.work += 1;
            return self.after_connecting();
        }
        let mut priors = [[Prior::default(); 2]; JUDGED_AT_ONCE];
        let constraints = &self.shared.constraints;
        let judge_both = |(&id, priors): (&TransitionId, &mut [Prior; 2])| {
            *priors = [id, Graph::twin(id)].map(|id| judge(constraints, id, graph));
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
        Ok(Phase::Judge)
    }

    /// An upper bound of the distance between two soles in a step, m: one leg's reach, and the hips apart.
    fn step_max(&self) -> f64 {
        let [left, right] = &self.shared.constraints.body.legs;
        left.reach().max(right.reach()) + left.hip().distance(right.hip())
    }
}
