//! The shortest-path search for the cheapest sequence of transitions [Grey 4.4.2].

use crate::base::arena::{LazilyFilled, filled, reserve};
use crate::motion::adjacency_lists::Swing;
use crate::motion::ids::{FootholdId, TransitionId};
use crate::motion::indexed_heap::IndexHeap;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::transition_sequence::{Objective, SequenceProblem};
use crate::motion::tuning::SWINGS_PER_UNIT;

/// Cost of a path: m^3, and number of transitions.
type Cost = (f64, u32);
/// Cost of a node that no path reaches.
const UNREACHED: Cost = (f64::INFINITY, 0);

/// How a transition is reached. 16 bytes, because there is one for each of up to a million
/// transitions.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    cost: f64,
    count: u32,
    /// The transition before it; itself at the start of the path.
    from: TransitionId,
}

impl Arrival {
    const NONE: Self = Self { cost: UNREACHED.0, count: UNREACHED.1, from: 0 };

    fn cost(&self) -> Cost {
        (self.cost, self.count)
    }
}

/// The arrays of the shortest-path search, allocated once.
///
/// The cost of a swing depends on its end, and on its beginning only if that very motion has
/// failed. So the first arrival on a stance foothold determines the costs of all its swings except
/// those with failed motions: a stance is expanded once, and each of its swings is followed by the
/// twin at once or skipped. Only arrivals that may be the first on their stance, or continue with a
/// swing whose motion has failed, wait in the heap.
#[derive(Debug)]
pub struct SequenceSearch {
    heap: IndexHeap,
    arrivals: LazilyFilled<Arrival>,
    /// The transitions and stance footholds that the last search reached, whose entries are reset
    /// before the next one.
    reached: Vec<TransitionId>,
    reached_stances: Vec<FootholdId>,
    stances: Vec<StanceRecord>,
    /// The footholds that were expanded as a stance.
    expanded: Vec<FootholdId>,
    sequence: Vec<TransitionId>,
    /// The cheapest arrival at the goal so far.
    best: Option<(f64, TransitionId)>,
}

/// State of a foothold in the search.
#[derive(Debug, Clone, Copy)]
struct StanceRecord {
    /// The cheapest arrival on it so far.
    arrival: Cost,
    /// Whether it has been expanded.
    is_expanded: bool,
    /// Whether it belongs to the walk whose steps are removed.
    is_used: bool,
}

impl SequenceSearch {
    /// Arrays with capacity for as many footholds and transitions. Allocates.
    pub fn new(footholds_max: usize, transitions_max: usize) -> Self {
        Self {
            heap: IndexHeap::new(transitions_max),
            arrivals: LazilyFilled::new(Arrival::NONE, transitions_max),
            reached: reserve(transitions_max),
            reached_stances: reserve(footholds_max),
            stances: filled(
                StanceRecord { arrival: UNREACHED, is_expanded: false, is_used: false },
                footholds_max,
            ),
            expanded: reserve(footholds_max),
            sequence: reserve(transitions_max),
            best: None,
        }
    }

    /// The sequence found last, from start to goal.
    pub fn sequence(&self) -> &[TransitionId] {
        &self.sequence
    }

    /// The footholds that the last search expanded as a stance.
    pub fn expanded(&self) -> &[FootholdId] {
        &self.expanded
    }

    /// Restricts searches for fewer steps to the footholds of a sequence.
    pub fn restrict_to(&mut self, graph: &ModeGraph, sequence: &[TransitionId]) {
        self.stances.iter_mut().for_each(|stance| stance.is_used = false);
        for transition in sequence.iter().map(|&id| &graph.transitions()[id as usize]) {
            self.stances[transition.stance as usize].is_used = true;
            self.stances[transition.other as usize].is_used = true;
        }
    }

    /// Begins the search for the cheapest sequence (Dijkstra; among equal costs the fewest
    /// transitions).
    pub fn begin(&mut self, problem: &SequenceProblem<'_>) {
        self.clear();
        for &start in problem.starts {
            if self.relax(
                problem,
                start,
                start,
                problem.failure_cost(problem.ends[0], start),
                (0.0, 0),
            ) {
                self.record_arrival(problem.graph, start);
                self.relax_twin(problem, start);
            }
        }
    }

    /// Spends at most `budget` work units of `SWINGS_PER_UNIT` swings each, on the problem that the
    /// search began with. Returns the units spent; fewer than the budget mean that the search has
    /// ended, see [`SequenceSearch::has_found`].
    pub fn advance(&mut self, problem: &SequenceProblem<'_>, budget: u64) -> u64 {
        for spent in 0..budget {
            let mut relaxed = 0;
            while relaxed < SWINGS_PER_UNIT {
                match self.expand(problem) {
                    Some(swings) => relaxed += swings + 1,
                    None => {
                        self.best
                            .iter()
                            .for_each(|&(_, goal)| trace(&self.arrivals, goal, &mut self.sequence));
                        return spent;
                    }
                }
            }
        }
        budget
    }

    /// Whether the search that has ended found a sequence.
    pub fn has_found(&self) -> bool {
        self.best.is_some()
    }

    /// Expands the cheapest arrival. Returns the number of swings relaxed; `None` at the end.
    fn expand(&mut self, problem: &SequenceProblem<'_>) -> Option<u64> {
        let (node, cost, count) = self.heap.pop()?;
        if self.best.is_some_and(|(least, _)| least <= cost) {
            self.heap.clear();
            return None;
        }
        let graph = problem.graph;
        let stance = graph.transitions()[node as usize].stance;
        if std::mem::replace(&mut self.stances[stance as usize].is_expanded, true) {
            return Some(self.relax_swings(
                problem,
                node,
                graph.failed_swings_from(stance),
                (cost, count),
            ));
        }
        self.expanded.push(stance);
        Some(self.relax_swings(problem, node, graph.swings_from(stance), (cost, count)))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.heap.bytes()
            + self.arrivals.bytes()
            + (self.reached.capacity() + self.sequence.capacity()) * size_of::<TransitionId>()
            + self.stances.len() * (size_of::<StanceRecord>() + 2 * size_of::<FootholdId>())
    }

    /// Resets the arrays that the last search changed.
    fn clear(&mut self) {
        self.heap.clear();
        self.best = None;
        self.sequence.clear();
        self.expanded.clear();
        for node in self.reached.drain(..) {
            self.arrivals[node as usize] = Arrival::NONE;
        }
        for stance in self.reached_stances.drain(..) {
            let record = &mut self.stances[stance as usize];
            (record.arrival, record.is_expanded) = (UNREACHED, false);
        }
    }

    /// Relaxes swings from a transition. Returns their number.
    fn relax_swings(
        &mut self,
        problem: &SequenceProblem<'_>,
        node: TransitionId,
        swings: impl Iterator<Item = Swing>,
        reached: Cost,
    ) -> u64 {
        let mut relaxed = 0;
        let has_failed_motion =
            problem.graph.has_failed_motion(problem.graph.transitions()[node as usize].stance);
        for swing in swings.filter(|swing| swing.to != node) {
            relaxed += 1;
            let is_skipped = !has_failed_motion
                && self.is_reached_for_less(problem, swing, reached)
                || !self.may_use(problem, swing.other);
            if is_skipped
                || !self.relax(problem, node, swing.to, problem.penalty(node, swing.to), reached)
            {
                continue;
            }
            if has_failed_motion {
                self.enqueue(swing.to);
            }
            self.relax_twin(problem, swing.to);
        }
        relaxed
    }

    /// Whether a swing leads, even without penalty, to a stance that was reached at lower cost and
    /// on which only the first arrival counts.
    fn is_reached_for_less(
        &self,
        problem: &SequenceProblem<'_>,
        Swing { to, other }: Swing,
        reached: Cost,
    ) -> bool {
        let arrival = (reached.0 + problem.step_cost(to), reached.1 + 2);
        arrival >= self.stances[other as usize].arrival
            && !problem.graph.has_failed_motion(other)
            && !problem.goal.contains(&other)
    }

    /// Relaxes the twin of a transition that was reached: the foot that landed carries the robot.
    fn relax_twin(&mut self, problem: &SequenceProblem<'_>, node: TransitionId) {
        let twin = ModeGraph::twin(node);
        if self.relax(
            problem,
            node,
            twin,
            problem.penalty(node, twin),
            self.arrivals[node as usize].cost(),
        ) {
            self.record_arrival(problem.graph, twin);
        }
    }

    /// Records the arrival on a transition's stance, if it is the first one there or if later ones
    /// count too.
    fn record_arrival(&mut self, graph: &ModeGraph, node: TransitionId) {
        let (cost, stance) =
            (self.arrivals[node as usize].cost(), graph.transitions()[node as usize].stance);
        let record = &mut self.stances[stance as usize];
        let is_first = cost < record.arrival;
        if is_first {
            if record.arrival == UNREACHED {
                self.reached_stances.push(stance);
            }
            record.arrival = cost;
        }
        if is_first || graph.has_failed_motion(stance) {
            self.enqueue(node);
        }
    }

    /// Puts a transition that was reached into the heap.
    fn enqueue(&mut self, node: TransitionId) {
        let (cost, count) = self.arrivals[node as usize].cost();
        self.heap.push(node, cost, count);
    }

    /// Whether the sequence may use a foothold.
    fn may_use(&self, problem: &SequenceProblem<'_>, foothold: FootholdId) -> bool {
        let vertex = problem.nearest_vertices[foothold as usize];
        let is_in_range = problem.vertex_range[0] <= vertex && vertex <= problem.vertex_range[1];
        is_in_range
            && (problem.objective != Objective::FewerSteps
                || self.stances[foothold as usize].is_used)
    }

    /// Records a path to a transition if it is cheaper than the known one. Returns whether it is.
    fn relax(
        &mut self,
        problem: &SequenceProblem<'_>,
        from: TransitionId,
        to: TransitionId,
        penalty: f64,
        reached: Cost,
    ) -> bool {
        let cost = (reached.0 + penalty + problem.cost(to), reached.1 + 1);
        let known = self.arrivals[to as usize].cost();
        if cost >= known {
            return false;
        }
        if known == UNREACHED {
            self.reached.push(to);
        }
        self.arrivals[to as usize] = Arrival { cost: cost.0, count: cost.1, from };
        if problem.is_goal(to) {
            let arrived = cost.0 + problem.failure_cost(to, problem.ends[1]);
            if self.best.is_none_or(|(least, _)| arrived < least) {
                self.best = Some((arrived, to));
            }
        }
        true
    }
}

/// Writes the path to a goal transition.
fn trace(arrivals: &LazilyFilled<Arrival>, goal: TransitionId, sequence: &mut Vec<TransitionId>) {
    let before = |at: &TransitionId| Some(arrivals[*at as usize].from).filter(|from| from != at);
    sequence.extend(std::iter::successors(Some(goal), before));
    sequence.reverse();
}

#[cfg(test)]
mod tests;
