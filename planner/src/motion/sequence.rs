//! The cheapest sequence of transitions from start to goal [Grey 4.4.2].

use crate::motion::edges::EdgeTable;
use crate::motion::graph::{FootholdId, Graph, TransitionId};
use crate::motion::heap::IndexHeap;

/// The penalty p for each failed single-mode search between two transitions: no less than the cost of a transition
/// that was never tried and is as long as a step can be [Grey 4.4.2].
pub const SINGLE_MODE_PENALTY: f64 = 1.0;

/// The part of the graph that a search looks at: placements near the stations of one segment.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a> {
    /// The station nearest to each placement.
    pub stations: &'a [u32],
    /// The first and the last station.
    pub range: [u32; 2],
}

impl Window<'_> {
    fn contains(&self, foothold: FootholdId) -> bool {
        let station = self.stations[foothold as usize];
        self.range[0] <= station && station <= self.range[1]
    }
}

/// The arrays of the shortest-path search, allocated once.
#[derive(Debug)]
pub struct SequenceSearch {
    heap: IndexHeap,
    costs: Vec<(f64, u32)>,
    came_from: Vec<Option<TransitionId>>,
    /// The transitions that the last search reached; the only ones whose entries it has changed.
    reached: Vec<TransitionId>,
    /// Which placements have been reached as a stance.
    is_entered: Vec<bool>,
    entered: Vec<FootholdId>,
    sequence: Vec<TransitionId>,
}

impl SequenceSearch {
    /// Arrays for this many placements and transitions.
    pub fn new(footholds_max: usize, transitions_max: usize) -> Self {
        Self {
            heap: IndexHeap::new(transitions_max),
            costs: vec![(f64::INFINITY, 0); transitions_max],
            came_from: vec![None; transitions_max],
            reached: Vec::with_capacity(transitions_max),
            is_entered: vec![false; footholds_max],
            entered: Vec::with_capacity(footholds_max),
            sequence: Vec::with_capacity(transitions_max),
        }
    }

    /// The sequence found last, start to goal.
    pub fn sequence(&self) -> &[TransitionId] {
        &self.sequence
    }

    /// The placements that the last search reached as a stance.
    pub fn entered(&self) -> &[FootholdId] {
        &self.entered
    }

    /// Finds the cheapest sequence from one of `starts` to a transition that `is_goal` accepts, which the first and the second
    /// of `ends` lie before and after (Dijkstra; among equal costs
    /// the fewest transitions). `false` where the graph holds none. Counts a unit of work for each 64 edges looked at.
    ///
    /// What a swing costs depends on where it leads, and on where it begins only if that very motion has failed. So the
    /// first arrival on a stance settles all its swings but the doubtful ones, and a stance is expanded once.
    #[allow(clippy::too_many_arguments, reason = "the problem of a shortest path: graph, costs, part, ends, goal")]
    pub fn find(
        &mut self,
        graph: &Graph,
        edges: &EdgeTable,
        window: Window<'_>,
        ends: [TransitionId; 2],
        starts: &[TransitionId],
        is_goal: &dyn Fn(TransitionId) -> bool,
        work: &mut u64,
    ) -> bool {
        self.clear();
        for &start in starts {
            self.relax(graph, None, start, penalty(edges, ends[0], start), (0.0, 0));
        }
        let mut looked_at = 0_u64;
        let mut best: Option<(f64, TransitionId)> = None;
        while let Some((node, cost, hops)) = self.heap.pop() {
            if best.is_some_and(|(least, _)| least <= cost) {
                break;
            }
            let arrived = cost + penalty(edges, node, ends[1]);
            if is_goal(node) && best.is_none_or(|(least, _)| arrived < least) {
                best = Some((arrived, node));
            }
            let twin = Graph::twin(node);
            let penalty = penalty(edges, node, twin);
            self.relax(graph, Some(node), twin, penalty, (cost, hops));
            let stance = graph.transitions()[node as usize].stance;
            if self.is_entered[stance as usize] {
                looked_at += self.relax_swings(graph, edges, window, node, graph.doubtful_from_stance(stance), (cost, hops));
            } else {
                self.is_entered[stance as usize] = true;
                self.entered.push(stance);
                looked_at += self.relax_swings(graph, edges, window, node, graph.from_stance(stance), (cost, hops));
            }
        }
        *work += looked_at / 64 + 1;
        if let Some((_, goal)) = best {
            self.trace(goal);
        }
        best.is_some()
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.heap.bytes()
            + self.costs.len() * (size_of::<(f64, u32)>() + size_of::<Option<TransitionId>>() + size_of::<TransitionId>())
            + self.reached.capacity() * size_of::<TransitionId>()
            + self.is_entered.len() * (1 + size_of::<FootholdId>())
    }

    /// Forgets the last search.
    fn clear(&mut self) {
        self.heap.clear();
        self.sequence.clear();
        for node in self.reached.drain(..) {
            self.costs[node as usize] = (f64::INFINITY, 0);
        }
        for stance in self.entered.drain(..) {
            self.is_entered[stance as usize] = false;
        }
    }

    /// Relaxes the swings from a transition to some on the same stance; answers how many there were.
    #[allow(clippy::too_many_arguments, reason = "what the search reads, and the step at hand")]
    fn relax_swings(
        &mut self,
        graph: &Graph,
        edges: &EdgeTable,
        window: Window<'_>,
        node: TransitionId,
        swings: impl Iterator<Item = TransitionId>,
        reached: (f64, u32),
    ) -> u64 {
        let mut looked_at = 0;
        for next in swings.filter(|&next| next != node) {
            looked_at += 1;
            let transition = &graph.transitions()[next as usize];
            let bound = reached.0 + transition.cost();
            if window.contains(transition.other) && (bound, reached.1 + 1) < self.costs[next as usize] {
                self.relax(graph, Some(node), next, penalty(edges, node, next), reached);
            }
        }
        looked_at
    }

    fn relax(&mut self, graph: &Graph, from: Option<TransitionId>, to: TransitionId, penalty: f64, reached: (f64, u32)) {
        let cost = (reached.0 + penalty + graph.transitions()[to as usize].cost(), reached.1 + 1);
        if cost < self.costs[to as usize] {
            if self.costs[to as usize].0.is_infinite() {
                self.reached.push(to);
            }
            self.costs[to as usize] = cost;
            self.came_from[to as usize] = from;
            self.heap.push(to, cost.0, cost.1);
        }
    }

    fn trace(&mut self, goal: TransitionId) {
        let came_from = &self.came_from;
        self.sequence.extend(std::iter::successors(Some(goal), |&at| came_from[at as usize]));
        self.sequence.reverse();
    }
}

fn penalty(edges: &EdgeTable, from: TransitionId, to: TransitionId) -> f64 {
    f64::from(edges.get(from, to).failures) * SINGLE_MODE_PENALTY
}
