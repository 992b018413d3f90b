//! The cheapest sequence of transitions from start to goal [Grey 4.4.2].

use crate::motion::edges::EdgeTable;
use crate::motion::graph::{FootholdId, Graph, TransitionId};
use crate::motion::heap::IndexHeap;

/// The penalty p for each failed single-mode search between two transitions: no less than the cost of a transition
/// that was never tried and is as long as a step can be [Grey 4.4.2].
pub const SINGLE_MODE_PENALTY: f64 = 1.0;

/// What a search looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Any walk: C(T), which costs nothing where a configuration is known [Grey 4.4.2].
    Find,
    /// A shorter walk, over the placements of one that was found: every transition costs [Grey 4.4.6].
    Shorten,
}

/// The problem of a search.
#[derive(Debug, Clone, Copy)]
pub struct Query<'a> {
    /// Modes and transitions.
    pub graph: &'a Graph,
    /// What is known of the motions between transitions.
    pub edges: &'a EdgeTable,
    /// What it looks for.
    pub purpose: Purpose,
    /// The station nearest to each placement.
    pub stations: &'a [u32],
    /// The first and the last station near which it may step.
    pub range: [u32; 2],
    /// The nodes before and after the sequence.
    pub ends: [TransitionId; 2],
    /// Where the sequence may begin.
    pub starts: &'a [TransitionId],
    /// The two placements on which it ends.
    pub goal: [FootholdId; 2],
}

/// What each transition costs in a shorter walk besides S(T) D^3(T), m^3: the best step is then some 0.3 m long.
const SHORTEN_BASE: f64 = 0.05;

impl Query<'_> {
    fn cost(&self, id: TransitionId) -> f64 {
        let transition = &self.graph.transitions()[id as usize];
        match self.purpose {
            Purpose::Find => transition.cost(),
            Purpose::Shorten => SHORTEN_BASE + transition.effort(),
        }
    }

    fn is_goal(&self, id: TransitionId) -> bool {
        let transition = &self.graph.transitions()[id as usize];
        self.goal.contains(&transition.stance) && self.goal.contains(&transition.other)
    }

    fn penalty(&self, from: TransitionId, to: TransitionId) -> f64 {
        f64::from(self.edges.get(from, to).failures) * SINGLE_MODE_PENALTY
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
    /// The placements of the walk that is being shortened.
    is_used: Vec<bool>,
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
            is_used: vec![false; footholds_max],
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

    /// Makes a sequence the one found last, as if the search had found it.
    pub fn restore(&mut self, sequence: &[TransitionId]) {
        self.sequence.clear();
        self.sequence.extend_from_slice(sequence);
    }

    /// Sets the placements that a search for a shorter walk may use: those of a sequence.
    pub fn use_only(&mut self, graph: &Graph, sequence: &[TransitionId]) {
        self.is_used.fill(false);
        for transition in sequence.iter().map(|&id| &graph.transitions()[id as usize]) {
            self.is_used[transition.stance as usize] = true;
            self.is_used[transition.other as usize] = true;
        }
    }

    /// Finds the cheapest sequence (Dijkstra; among equal costs the fewest transitions). `false` where the graph holds none.
    /// Counts a unit of work for each 64 edges looked at.
    ///
    /// What a swing costs depends on where it leads, and on where it begins only if that very motion has failed. So the
    /// first arrival on a stance settles all its swings but the doubtful ones, and a stance is expanded once.
    pub fn find(&mut self, query: &Query<'_>, work: &mut u64) -> bool {
        self.clear();
        for &start in query.starts {
            self.relax(query, None, start, query.penalty(query.ends[0], start), (0.0, 0));
        }
        let graph = query.graph;
        let mut looked_at = 0_u64;
        let mut best: Option<(f64, TransitionId)> = None;
        while let Some((node, cost, hops)) = self.heap.pop() {
            if best.is_some_and(|(least, _)| least <= cost) {
                break;
            }
            let arrived = cost + query.penalty(node, query.ends[1]);
            if query.is_goal(node) && best.is_none_or(|(least, _)| arrived < least) {
                best = Some((arrived, node));
            }
            let twin = Graph::twin(node);
            self.relax(query, Some(node), twin, query.penalty(node, twin), (cost, hops));
            let stance = graph.transitions()[node as usize].stance;
            if self.is_entered[stance as usize] {
                looked_at += self.relax_swings(query, node, graph.doubtful_from_stance(stance), (cost, hops));
            } else {
                self.is_entered[stance as usize] = true;
                self.entered.push(stance);
                looked_at += self.relax_swings(query, node, graph.from_stance(stance), (cost, hops));
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
            + self.is_entered.len() * (2 + size_of::<FootholdId>())
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
    fn relax_swings(
        &mut self,
        query: &Query<'_>,
        node: TransitionId,
        swings: impl Iterator<Item = TransitionId>,
        reached: (f64, u32),
    ) -> u64 {
        let mut looked_at = 0;
        for next in swings.filter(|&next| next != node) {
            looked_at += 1;
            let bound = reached.0 + query.cost(next);
            if self.may_use(query, query.graph.transitions()[next as usize].other) && (bound, reached.1 + 1) < self.costs[next as usize] {
                self.relax(query, Some(node), next, query.penalty(node, next), reached);
            }
        }
        looked_at
    }

    fn may_use(&self, query: &Query<'_>, foothold: FootholdId) -> bool {
        let station = query.stations[foothold as usize];
        let is_near = query.range[0] <= station && station <= query.range[1];
        is_near && (query.purpose == Purpose::Find || self.is_used[foothold as usize])
    }

    fn relax(&mut self, query: &Query<'_>, from: Option<TransitionId>, to: TransitionId, penalty: f64, reached: (f64, u32)) {
        let cost = (reached.0 + penalty + query.cost(to), reached.1 + 1);
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
