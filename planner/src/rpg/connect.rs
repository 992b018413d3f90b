//! Transitions between the placements, and how likely each is [Grey 4.4.2].

use rayon::prelude::*;

use super::{Phase, Planner};
use crate::motion::graph::{ArenaFull, FootholdId, Graph, TransitionId};
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
        let mut in_vain = [[0; 2]; JUDGED_AT_ONCE];
        let constraints = &self.shared.constraints;
        let judge_both = |(&id, counts): (&TransitionId, &mut [u32; 2])| {
            *counts = [id, Graph::twin(id)].map(|id| judge(constraints, id, graph));
        };
        if self.shared.parallel {
            next.par_iter().zip(&mut in_vain).with_max_len(1).for_each(judge_both);
        } else {
            next.iter().zip(&mut in_vain).for_each(judge_both);
        }
        for (&id, [count, twin_count]) in next.iter().zip(in_vain) {
            graph.record_failures(id, count);
            graph.record_failures(Graph::twin(id), twin_count);
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
