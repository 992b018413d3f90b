//! Transitions between the placements, and how likely each is [Grey 4.4.2].

use super::{Phase, Planner};
use crate::allowance::items_in;
use crate::motion::foothold::{Foothold, left_and_right};
use crate::motion::graph::{ArenaFull, FootholdId, Graph, Prior, TransitionId};
use crate::possibility::Station;
use crate::seeding::{Neighbours, Seeding, judge};
use crate::trouble::nearest_station;

/// Transitions or placements that are looked at side by side.
const AT_ONCE: usize = 64;
/// The station of a placement that is not used on the route.
const NOWHERE: u32 = u32::MAX;

type Batch<T> = heapless::Vec<T, AT_ONCE>;

impl Planner {
    /// Connects the next placements with their neighbours, as many as a budget allows, each one unit of work; once all are, counts each
    /// to the nearest station.
    pub(super) fn connect(&mut self, next: FootholdId, budget: u64) -> Result<Phase, ArenaFull> {
        let count = self.roadmap.graph.footholds().len();
        if next as usize == count {
            return if self.locate_next(budget) { Ok(Phase::Connect { next }) } else { self.after_connecting() };
        }
        let ids: Batch<FootholdId> = (next..count as FootholdId).take(items_in(budget, AT_ONCE)).collect();
        let steps = self.shared.preparation.possible_steps();
        let (seeding, graph, stretches) = (Seeding::of(&self.shared), &self.roadmap.graph, self.stretches);
        let neighbours = |id: FootholdId| {
            let is_due = |a: &Foothold, b: &Foothold| {
                let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
                if steps.may_step(soles) { id >= graph.connected() } else { stretches }
            };
            seeding.neighbours(id, steps.reach(), is_due, graph)
        };
        let connected: Batch<Neighbours> = self.shared.threads.map(&ids, neighbours);
        for (&id, neighbours) in ids.iter().zip(connected) {
            self.tally.work += 1;
            for neighbour in neighbours {
                self.roadmap.graph.connect(id, neighbour)?;
            }
            self.roadmap.graph.mark_connected(id);
        }
        Ok(Phase::Connect { next: next + ids.len() as FootholdId })
    }

    /// Finds the nearest stations of the next placements that are new, as many as a budget allows; of all, after the route has changed.
    /// `false` when each has been looked at.
    fn locate_next(&mut self, budget: u64) -> bool {
        let (route, footholds) = (self.growth.route(), self.roadmap.graph.footholds());
        let ids: Batch<usize> = (self.nearest_stations.len()..footholds.len()).take(items_in(budget, AT_ONCE)).collect();
        let locate = |id: usize| {
            let world_from_sole = &footholds[id].world_from_sole;
            let suits = route.suits(&Station::of_sole(world_from_sole));
            (nearest_station(route, world_from_sole.translation), suits)
        };
        let located: Batch<(usize, bool)> = self.shared.threads.map(&ids, locate);
        self.tally.work += ids.len().max(1) as u64;
        for (&id, (station, suits)) in ids.iter().zip(located) {
            self.roadmap.graph.set_stoop(id as FootholdId, self.stooping.stoop(station));
            self.nearest_stations.push(if suits { station as u32 } else { NOWHERE });
        }
        !ids.is_empty()
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
        let may_be_scant = self.tally.routes > 1 || self.tally.sweeps > 1;
        let (constraints, graph) = (&self.shared.constraints, &self.roadmap.graph);
        let judge_both = |id: TransitionId| [id, Graph::twin(id)].map(|id| judge(constraints, id, graph, may_be_scant));
        let priors: Batch<[Prior; 2]> = self.shared.threads.map(&next, judge_both);
        let graph = &mut self.roadmap.graph;
        for (&id, [prior, twin_prior]) in next.iter().zip(priors) {
            graph.record_prior(id, prior);
            graph.record_prior(Graph::twin(id), twin_prior);
        }
        self.tally.work += next.len() as u64;
        Phase::Judge
    }

    /// The next transitions to judge, as many as a budget allows, one of each pair of twins: those of the sequence found last, then all
    /// on the placements of those that turn out to be unlikely, since the next sequence would only go through the next of these.
    fn next_to_judge(&self, budget: u64) -> Batch<TransitionId> {
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
