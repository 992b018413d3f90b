//! Estimates of the prior costs of transitions [Grey 4.4.2], in batches.

use crate::base::work_budget::items_in;
use crate::motion::ids::TransitionId;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::transition::TransitionPrior;
use crate::motion::transition_prior::transition_prior;
use crate::pipeline::segment_searches::{SegmentSearches, SegmentState};
use crate::preparation::planning_context::PlanningContext;

/// Transitions that are estimated in one batch, each with its twin.
const BATCH_MAX: usize = 64;

/// One item for each transition of a batch.
pub(crate) type Batch<T> = heapless::Vec<T, BATCH_MAX>;

/// Transitions to estimate, one of each pair of twins, and the priors of the first of them. The
/// graph gets the priors once all are known, so that a search that runs in parallel meets the same
/// costs from its beginning to its end.
#[derive(Debug, Default)]
pub(crate) struct TransitionEstimates {
    ids: Batch<TransitionId>,
    priors: Batch<[TransitionPrior; 2]>,
}

impl TransitionEstimates {
    /// Gathers the transitions to estimate of all segments that need some, if none is gathered.
    pub fn gather(&mut self, segments: &mut SegmentSearches, graph: &ModeGraph) {
        if !self.ids.is_empty() {
            return;
        }
        let active = segments.active().map(|(_, search)| search);
        for search in active.filter(|search| search.state == SegmentState::Estimate) {
            for id in unestimated(graph, &search.sequence) {
                if !self.ids.contains(&id) && self.ids.push(id).is_err() {
                    return;
                }
            }
        }
    }

    /// Estimates the next transitions and their twins, as many as `budget` allows, each in
    /// parallel with the others and with `first`. With `may_be_partial`, partial support adds no
    /// cost.
    pub fn estimate<A>(
        &self,
        (context, graph): (&PlanningContext, &ModeGraph),
        may_be_partial: bool,
        budget: u64,
        first: impl FnOnce() -> A,
    ) -> (A, Batch<[TransitionPrior; 2]>) {
        let left = &self.ids[self.priors.len()..];
        let due = &left[..items_in(budget, left.len())];
        let both: heapless::Vec<TransitionId, { 2 * BATCH_MAX }> =
            due.iter().flat_map(|&id| [id, ModeGraph::twin(id)]).collect();
        let prior = |id| transition_prior(&context.constraints, id, graph, may_be_partial);
        let (made, priors) = context.threads.map_beside(first, &both, prior);
        (made, priors.as_chunks().0.iter().copied().collect())
    }

    /// Adds the priors of the next transitions.
    pub fn extend(&mut self, priors: Batch<[TransitionPrior; 2]>) {
        self.priors.extend(priors);
    }

    /// Whether all priors are known.
    pub fn is_complete(&self) -> bool {
        self.priors.len() == self.ids.len()
    }

    /// Gives the graph all priors. Segments without a transition to estimate search a sequence
    /// again.
    pub fn record(&mut self, segments: &mut SegmentSearches, graph: &mut ModeGraph) {
        for (&id, &[prior, twin_prior]) in self.ids.iter().zip(&self.priors) {
            graph.record_prior(id, prior);
            graph.record_prior(ModeGraph::twin(id), twin_prior);
        }
        self.ids.clear();
        self.priors.clear();
        let active = segments.active().map(|(_, search)| search);
        for search in active.filter(|search| search.state == SegmentState::Estimate) {
            if unestimated(graph, &search.sequence).next().is_none() {
                search.state = SegmentState::Seek;
            }
        }
    }
}

/// The transitions to estimate for a sequence, one of each pair of twins, some perhaps twice: those
/// of the sequence, then all on the stance footholds of its unlikely ones, since the next sequence
/// would use one of these.
fn unestimated<'a>(
    graph: &'a ModeGraph,
    sequence: &'a [TransitionId],
) -> impl Iterator<Item = TransitionId> + 'a {
    let unlikely = sequence
        .iter()
        .filter(|&&id| graph.is_unlikely(id))
        .flat_map(|&id| [id, ModeGraph::twin(id)]);
    let neighbours =
        unlikely.flat_map(|id| graph.of_stance(graph.transitions()[id as usize].stance));
    let all = sequence.iter().copied().chain(neighbours);
    all.filter(|&id| graph.is_unestimated(id)).map(|id| id.min(ModeGraph::twin(id)))
}
