//! Searches the cheapest sequence of transitions of a segment [Grey 4.4.2], alone or in parallel
//! with the estimates of other segments' transitions.

use surefoot_shared_types::message::SupportMode;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::{FootholdId, TransitionId, boundary_node};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::{Boundary, Roadmap};
use crate::motion::sequence_search::SequenceSearch;
use crate::motion::transition_sequence::{Objective, SequenceProblem};
use crate::pipeline::search::Search;
use crate::pipeline::segment_searches::{SegmentSearch, SegmentState};
use crate::pipeline::segmentation::Segmentation;
use crate::pipeline::stage::Event;
use crate::pipeline::step_removal::take_shorter;
use crate::pipeline::transition_estimates::TransitionEstimates;
use crate::preparation::planning_context::PlanningContext;

/// Most transitions that a start on one foot leads to directly. Further ones are reached through
/// these.
const STARTS_MAX: usize = 256;

/// The ends and the objective of a sequence.
#[derive(Debug)]
struct SequenceQuery {
    objective: Objective,
    /// The first and the last vertex near which it may use footholds.
    vertex_range: [u32; 2],
    /// The nodes before and after it.
    ends: [TransitionId; 2],
    starts: heapless::Vec<TransitionId, STARTS_MAX>,
    goal: [FootholdId; 2],
}

impl SequenceQuery {
    /// The query of a segment. With [`Objective::FromGoal`] it leads from the segment's end to its
    /// start.
    fn new(search: &SegmentSearch, roadmap: &Roadmap, segmentation: &Segmentation) -> Self {
        let [start, goal] = segmentation.boundaries(search.segment);
        let is_reverse = search.objective == Objective::FromGoal;
        let [from, to] = if is_reverse { [goal, start] } else { [start, goal] };
        Self {
            objective: search.objective,
            vertex_range: segmentation.vertex_range(search.segment),
            ends: [from, to].map(boundary_node),
            starts: start_transitions(&roadmap.graph, roadmap.boundary(from)),
            goal: roadmap.boundary(to).footholds,
        }
    }

    /// The query on Gamma_M, with the vertex nearest to each foothold.
    fn on<'a>(&'a self, roadmap: &'a Roadmap, nearest_vertices: &'a [u32]) -> SequenceProblem<'a> {
        let Self { objective, vertex_range, ends, ref starts, goal } = *self;
        SequenceProblem {
            graph: &roadmap.graph,
            edges: &roadmap.edges,
            modes: &roadmap.costs,
            objective,
            nearest_vertices,
            vertex_range,
            ends,
            starts,
            goal,
        }
    }
}

/// The transitions that a boundary leads to: on both feet those between its two footholds, on one
/// foot all on the foothold that carries the robot.
fn start_transitions(
    graph: &ModeGraph,
    boundary: &Boundary,
) -> heapless::Vec<TransitionId, STARTS_MAX> {
    let [left, right] = boundary.footholds;
    match boundary.support {
        SupportMode::Left => graph.of_stance(left).take(STARTS_MAX).collect(),
        SupportMode::Right => graph.of_stance(right).take(STARTS_MAX).collect(),
        SupportMode::Double => {
            let from_left = graph.find_all(left, right).take(STARTS_MAX / 2);
            from_left.chain(graph.find_all(right, left).take(STARTS_MAX / 2)).collect()
        }
    }
}

/// The search of the current segment's sequence, allocated once.
#[derive(Debug)]
struct SequenceSearcher {
    search: SequenceSearch,
    /// The query of the current segment, until its result is taken.
    query: Option<SequenceQuery>,
    /// Whether the search has more to do.
    is_running: bool,
}

impl SequenceSearcher {
    /// Begins to search the sequence of the current segment.
    fn begin(&mut self, search: &mut Search) {
        let Search { roadmap, segments, segmentation, connections, .. } = search;
        let current = segments.current();
        let query = SequenceQuery::new(current, roadmap, segmentation);
        match current.objective {
            Objective::ConnectModes => roadmap.costs.update_connections(&roadmap.graph, query.ends),
            Objective::FewerSteps => self.search.restrict_to(&roadmap.graph, &current.best),
            Objective::Feasible | Objective::FromGoal => {}
        }
        self.search.begin(&query.on(roadmap, &connections.nearest_vertices));
        (self.query, self.is_running) = (Some(query), true);
    }

    /// Advances the search by at most `budget` units of work. Returns the units spent.
    fn advance(&mut self, search: &Search, budget: u64) -> u64 {
        let Some(query) = &self.query else { return 0 };
        let query = query.on(&search.roadmap, &search.connections.nearest_vertices);
        let spent = self.search.advance(&query, budget);
        self.is_running = spent == budget;
        spent
    }
}

/// Searches the cheapest sequence of the current segment, and estimates the transitions of
/// sequences that were found: until all transitions of a sequence are estimated, it may not be the
/// cheapest, since a transition without an estimate costs as little as it can. Makes a sequence for
/// each segment. Serves the stages `Estimates` and `Sequence`.
#[derive(Debug)]
pub(crate) struct SequenceStage {
    searcher: SequenceSearcher,
    estimates: TransitionEstimates,
}

impl SequenceStage {
    /// Reserves memory for this many footholds and transitions.
    pub fn new(footholds_max: usize, transitions_max: usize) -> Self {
        let search = SequenceSearch::new(footholds_max, transitions_max);
        Self {
            searcher: SequenceSearcher { search, query: None, is_running: false },
            estimates: TransitionEstimates::default(),
        }
    }

    /// Advances the search and the estimates by at most `budget` units of work: one for each
    /// expansion, and one for each estimate.
    ///
    /// # Errors
    /// A sequence has more transitions than may have configurations.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if self.searcher.query.is_none() && search.segments.needs_sequence() {
            self.searcher.begin(search);
        }
        let is_estimating = search.segments.is_estimating();
        let is_over = if is_estimating {
            self.estimates.gather(&mut search.segments, &search.roadmap.graph);
            self.advance_with_estimates(context, search, budget)
        } else {
            search.stats.work += self.searcher.advance(search, budget);
            !self.searcher.is_running
        };
        if !is_over {
            return Ok(Event::Continue);
        }
        search.stats.work += 1;
        if is_estimating {
            self.estimates.record(&mut search.segments, &mut search.roadmap.graph);
        }
        self.finish(search)?;
        Ok(Event::Done)
    }

    /// Advances the search and the estimates in parallel, the search with half of the budget until
    /// it has ended. Returns whether both have ended.
    fn advance_with_estimates(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> bool {
        let Self { searcher, estimates } = self;
        let may_be_partial = search.may_use_partial_support();
        let graph = &search.roadmap.graph;
        let budget_of_search = if searcher.is_running { budget.div_ceil(2) } else { 0 };
        let advance = || match searcher.is_running {
            true => searcher.advance(search, budget_of_search),
            false => 0,
        };
        let left = budget - budget_of_search;
        let (spent, priors) = estimates.estimate((context, graph), may_be_partial, left, advance);
        let spent = spent + priors.len() as u64;
        estimates.extend(priors);
        let is_over = spent < budget && !searcher.is_running && estimates.is_complete();
        search.stats.work += spent;
        is_over
    }

    /// Gives the current segment its next task, if a sequence was searched for it.
    fn finish(&mut self, search: &mut Search) -> Result<(), ArenaFull> {
        let Some(SequenceQuery { objective, .. }) = self.searcher.query.take() else {
            return Ok(());
        };
        let found = self.searcher.search.has_found().then(|| self.searcher.search.sequence());
        let is_unestimated = |id: &TransitionId| search.roadmap.graph.is_unestimated(*id);
        let needs_estimates = found.is_some_and(|found| found.iter().any(is_unestimated));
        let sample = SegmentState::Sample { next: 0, failed: false };
        let current = search.segments.current_mut();
        match (objective, found) {
            (Objective::Feasible | Objective::FewerSteps, Some(found)) if needs_estimates => {
                current.take(found, SegmentState::Estimate)
            }
            (Objective::Feasible, found) => {
                search.stats.sequences += 1;
                let Some(found) = found else {
                    self.search_from_goal(search);
                    return Ok(());
                };
                current.take(found, sample)
            }
            (Objective::FromGoal, _) => {
                self.meet_frontiers(search);
                Ok(())
            }
            (Objective::ConnectModes, Some(found)) => {
                current.take(found, SegmentState::Move { next: 0, failed: false })
            }
            (Objective::ConnectModes, None) => {
                current.state = SegmentState::Failed;
                Ok(())
            }
            (Objective::FewerSteps, found) => take_shorter(search, found),
        }
    }

    /// No sequence connects both ends: notes the last vertex that is reached from the start, and
    /// searches from the end.
    fn search_from_goal(&self, search: &mut Search) {
        let [first, _] = search.segmentation.vertices(search.segments.current().segment);
        let reached = self.reached_vertices(search).max().unwrap_or(first);
        let current = search.segments.current_mut();
        current.frontiers[0] = reached;
        current.seek(Objective::FromGoal);
    }

    /// Notes the first vertex that is reached from the end. The segment needs recovery.
    fn meet_frontiers(&self, search: &mut Search) {
        let [_, last] = search.segmentation.vertices(search.segments.current().segment);
        let reached = self.reached_vertices(search).min().unwrap_or(last);
        let current = search.segments.current_mut();
        current.frontiers[1] = reached;
        current.state = SegmentState::Disconnected;
    }

    /// The vertices of the current segment near which the last search reached a stance.
    fn reached_vertices<'a>(&'a self, search: &'a Search) -> impl Iterator<Item = usize> + 'a {
        let [first, last] = search.segmentation.vertices(search.segments.current().segment);
        let nearest = &search.connections.nearest_vertices;
        let reached =
            self.searcher.search.expanded().iter().map(|&id| nearest[id as usize] as usize);
        reached.filter(move |vertex| (first..=last).contains(vertex))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.searcher.search.bytes()
    }
}
