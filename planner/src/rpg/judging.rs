//! Judging how likely transitions are [Grey 4.4.2], by itself or beside the search for another
//! lane's sequence.

use crate::base::work_budget::items_in;
use crate::motion::mode_graph::{ArenaFull, ModeGraph, TransitionId, TransitionPrior};
use crate::preparation::planning_context::Shared;
use crate::rpg::lanes::Turn;
use crate::rpg::{Phase, Planner};
use crate::seeding::judge;

/// Transitions that are judged side by side, each with its twin.
const AT_ONCE: usize = 64;

type Batch<T> = heapless::Vec<T, AT_ONCE>;

/// Transitions to judge, one of each pair of twins, and what has come of the first of them. The
/// graph learns of it once all are judged, so that a search in the meantime meets the same costs
/// from its beginning to its end.
#[derive(Debug, Default)]
pub struct Judging {
    ids: Batch<TransitionId>,
    priors: Batch<[TransitionPrior; 2]>,
}

impl Judging {
    /// The next ones to judge, as many as a budget allows.
    fn due(&self, budget: u64) -> Batch<TransitionId> {
        let left = &self.ids[self.priors.len()..];
        left[..items_in(budget, left.len())].iter().copied().collect()
    }

    fn is_over(&self) -> bool {
        self.priors.len() == self.ids.len()
    }

    /// Tells the graph all that it does not know yet.
    fn record(&mut self, graph: &mut ModeGraph) {
        for (&id, &[prior, twin_prior]) in self.ids.iter().zip(&self.priors) {
            graph.record_prior(id, prior);
            graph.record_prior(ModeGraph::twin(id), twin_prior);
        }
        self.ids.clear();
        self.priors.clear();
    }
}

/// How likely these transitions and their twins are, each of both by itself: often there are only
/// one or two.
fn judge_all(
    shared: &Shared,
    graph: &ModeGraph,
    ids: &Batch<TransitionId>,
    may_be_scant: bool,
) -> Batch<[TransitionPrior; 2]> {
    let all: heapless::Vec<TransitionId, { 2 * AT_ONCE }> =
        ids.iter().flat_map(|&id| [id, ModeGraph::twin(id)]).collect();
    let priors = shared.threads.map(&all, |id| judge(&shared.constraints, id, graph, may_be_scant));
    priors.as_chunks().0.iter().copied().collect()
}

/// The transitions to judge for a sequence, twins by one of them, some perhaps twice: those that it
/// holds, then all on the placements of those that turn out to be unlikely, since the next sequence
/// would only go through the next of these.
fn unjudged<'a>(
    graph: &'a ModeGraph,
    sequence: &'a [TransitionId],
) -> impl Iterator<Item = TransitionId> + 'a {
    let unlikely = sequence
        .iter()
        .filter(|&&id| graph.is_unlikely(id))
        .flat_map(|&id| [id, ModeGraph::twin(id)]);
    let neighbours =
        unlikely.flat_map(|id| graph.from_stance(graph.transitions()[id as usize].stance));
    sequence
        .iter()
        .copied()
        .chain(neighbours)
        .filter(|&id| graph.is_unestimated(id))
        .map(|id| id.min(ModeGraph::twin(id)))
}

impl Planner {
    /// Judges what is to be judged before the next sequence is sought, beside another lane's
    /// search. What is not judged yet costs as little as it can, so the cheapest sequence is the
    /// cheapest of all once all that it holds is judged.
    pub(crate) fn judge(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        let may_be_scant = self.may_be_scant();
        let Self { judging, seeker, shared, roadmap, nearest_stations, .. } = self;
        let judge =
            |budget: u64| judge_all(shared, &roadmap.graph, &judging.due(budget), may_be_scant);
        let (sought, priors) =
            seeker.advance_beside((roadmap, nearest_stations), &shared.threads, budget, judge);
        let spent = sought + priors.len() as u64;
        self.tally.work += spent;
        judging.priors.extend(priors);
        if spent == budget || seeker.is_going() || !judging.is_over() {
            return Ok(Phase::Judge);
        }
        self.tally.work += 1;
        self.after_judging();
        self.after_search()
    }

    /// Whether scant support is no reason to think less of a transition: where better placements
    /// have led nowhere.
    fn may_be_scant(&self) -> bool {
        self.tally.routes > 1 || self.tally.sweeps > 1
    }

    /// Gathers the next transitions to judge of all lanes that have some.
    pub(crate) fn begin_judging(&mut self) {
        let Self { judging, lanes, roadmap, .. } = self;
        for (_, lane) in lanes.going().filter(|(_, lane)| lane.turn == Turn::Judge) {
            for id in unjudged(&roadmap.graph, &lane.sequence) {
                if !judging.ids.contains(&id) && judging.ids.push(id).is_err() {
                    return;
                }
            }
        }
    }

    /// All that was gathered is judged: lanes with nothing left to judge look for a sequence again.
    fn after_judging(&mut self) {
        let Self { judging, lanes, roadmap, .. } = self;
        judging.record(&mut roadmap.graph);
        for (_, lane) in lanes.going().filter(|(_, lane)| lane.turn == Turn::Judge) {
            if unjudged(&roadmap.graph, &lane.sequence).next().is_none() {
                lane.turn = Turn::Seek;
            }
        }
    }
}
