//! The cheapest sequence of transitions from start to goal [Grey 4.4.2].

use crate::base::arena::{LazilyFilled, filled, reserve};
use crate::motion::adjacency_lists::Swing;
use crate::motion::edge_table::EdgeTable;
use crate::motion::indexed_heap::IndexHeap;
use crate::motion::mode_costs::ModeCosts;
use crate::motion::mode_graph::{FootholdId, ModeGraph, TransitionId};

/// The penalty p for each failed single-mode search between two transitions: no less than the cost
/// of a transition that was never tried and is as long as a step usually is, however unlikely it
/// looks [Grey 4.4.2].
pub const SINGLE_MODE_PENALTY: f64 = 4.0;

/// What a search looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Any walk: C(T), which costs nothing where a configuration is known [Grey 4.4.2].
    Feasible,
    /// How far walks lead from the goal back toward the start, where there is none from one to the
    /// other [Grey 4.4.4].
    FromGoal,
    /// The modes to search next, over transitions with a configuration alone: what these cost
    /// [Grey 4.4.3].
    ConnectModes,
    /// A shorter walk, over the placements of one that was found: every transition costs
    /// [Grey 4.4.6].
    FewerSteps,
}

/// The problem of a search.
#[derive(Debug, Clone, Copy)]
pub struct SequenceProblem<'a> {
    /// Modes and transitions.
    pub graph: &'a ModeGraph,
    /// What is known of the motions between transitions.
    pub edges: &'a EdgeTable,
    /// What the modes cost.
    pub modes: &'a ModeCosts,
    /// What it looks for.
    pub objective: Objective,
    /// The station nearest to each placement; none of the range for one that is not used on the
    /// route.
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

/// What each transition costs in a shorter walk in addition to S(T) D^3(T), m^3: the best step is
/// then some 0.3 m long.
const FEWER_STEPS_BASE: f64 = 0.05;

impl SequenceProblem<'_> {
    fn cost(&self, id: TransitionId) -> f64 {
        let transition = &self.graph.transitions()[id as usize];
        match self.objective {
            Objective::Feasible | Objective::FromGoal => transition.cost(),
            Objective::ConnectModes if transition.is_found() => self.modes.cost(self.graph, id),
            Objective::ConnectModes => f64::INFINITY,
            Objective::FewerSteps => FEWER_STEPS_BASE + transition.effort(),
        }
    }

    /// What it costs to swing a foot to a transition and to set it down.
    fn step_cost(&self, to: TransitionId) -> f64 {
        match self.objective {
            Objective::Feasible | Objective::FromGoal => self.graph.step_cost(to),
            Objective::ConnectModes | Objective::FewerSteps => {
                self.cost(to) + self.cost(ModeGraph::twin(to))
            }
        }
    }

    fn is_goal(&self, id: TransitionId) -> bool {
        let transition = &self.graph.transitions()[id as usize];
        self.goal.contains(&transition.stance) && self.goal.contains(&transition.other)
    }

    /// What the failed searches for a motion between two transitions cost.
    fn penalty(&self, from: TransitionId, to: TransitionId) -> f64 {
        if self.graph.may_have_failed(from, to) { self.failure_cost(from, to) } else { 0.0 }
    }

    /// The same, also where one of them is the node of a boundary.
    fn failure_cost(&self, from: TransitionId, to: TransitionId) -> f64 {
        match self.objective {
            Objective::ConnectModes => 0.0,
            Objective::Feasible | Objective::FromGoal | Objective::FewerSteps => {
                f64::from(self.edges.get(from, to).failures) * SINGLE_MODE_PENALTY
            }
        }
    }
}

/// What a way costs: m^3, and its transitions.
type Cost = (f64, u32);
/// Of what no way leads to.
const UNREACHED: Cost = (f64::INFINITY, 0);

/// How a transition is reached, in 16 bytes: there is one for each of a million.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    cost: f64,
    count: u32,
    /// The transition before it; itself where the way begins.
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
/// What a swing costs depends on where it leads, and on where it begins only if that very motion
/// has failed. So the first arrival on a stance settles all its swings but the those with failed
/// motions: a stance is expanded once, each of its swings is set down at once or passed over, and
/// only arrivals that may be the first on their stance, or lead on to those with failed motions,
/// wait in the heap.
#[derive(Debug)]
pub struct SequenceSearch {
    heap: IndexHeap,
    arrivals: LazilyFilled<Arrival>,
    /// The transitions that the last search reached, and the stances; the only ones whose entries
    /// it has changed.
    reached: Vec<TransitionId>,
    reached_stances: Vec<FootholdId>,
    stances: Vec<StanceRecord>,
    /// The placements that have been reached as a stance.
    expanded: Vec<FootholdId>,
    sequence: Vec<TransitionId>,
    /// The cheapest arrival at the goal so far.
    best: Option<(f64, TransitionId)>,
}

/// What is known of a placement.
#[derive(Debug, Clone, Copy)]
struct StanceRecord {
    /// The cheapest arrival on it so far.
    arrival: Cost,
    /// Whether it has been expanded.
    is_expanded: bool,
    /// Whether it belongs to the walk that is being shortened.
    is_used: bool,
}

/// Swings that one unit of work looks at, or those of one stance where they are more.
const SWINGS_PER_UNIT: u64 = 64;

impl SequenceSearch {
    /// Arrays for this many placements and transitions.
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

    /// The sequence found last, start to goal.
    pub fn sequence(&self) -> &[TransitionId] {
        &self.sequence
    }

    /// The placements that the last search reached as a stance.
    pub fn expanded(&self) -> &[FootholdId] {
        &self.expanded
    }

    /// Sets the placements that a search for a shorter walk may use: those of a sequence.
    pub fn restrict_to(&mut self, graph: &ModeGraph, sequence: &[TransitionId]) {
        self.stances.iter_mut().for_each(|stance| stance.is_used = false);
        for transition in sequence.iter().map(|&id| &graph.transitions()[id as usize]) {
            self.stances[transition.stance as usize].is_used = true;
            self.stances[transition.other as usize].is_used = true;
        }
    }

    /// Begins to look for the cheapest sequence (Dijkstra; among equal costs the fewest
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
                self.set_down(problem, start);
            }
        }
    }

    /// Spends at most so many units of work, of `SWINGS_PER_UNIT` swings each; answers how many it
    /// spent. The same query as at the beginning. Once less is spent than allowed, the search has
    /// ended, see [`SequenceSearch::has_found`].
    pub fn advance(&mut self, problem: &SequenceProblem<'_>, budget: u64) -> u64 {
        for spent in 0..budget {
            let mut looked_at = 0;
            while looked_at < SWINGS_PER_UNIT {
                match self.expand(problem) {
                    Some(swings) => looked_at += swings + 1,
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

    /// Expands the nearest arrival; answers how many swings it looked at, or `None` at the end.
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

    /// Forgets the last search.
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

    /// Relaxes some swings from a transition; answers how many there were.
    fn relax_swings(
        &mut self,
        problem: &SequenceProblem<'_>,
        node: TransitionId,
        swings: impl Iterator<Item = Swing>,
        reached: Cost,
    ) -> u64 {
        let mut looked_at = 0;
        let has_failed_motion =
            problem.graph.has_failed_motion(problem.graph.transitions()[node as usize].stance);
        for swing in swings.filter(|swing| swing.to != node) {
            looked_at += 1;
            let is_useless = !has_failed_motion
                && self.is_reached_for_less(problem, swing, reached)
                || !self.may_use(problem, swing.other);
            if is_useless
                || !self.relax(problem, node, swing.to, problem.penalty(node, swing.to), reached)
            {
                continue;
            }
            if has_failed_motion {
                self.enqueue(swing.to);
            }
            self.set_down(problem, swing.to);
        }
        looked_at
    }

    /// Whether a swing, even without any penalty, leads to a stance that has been reached for less,
    /// where only the first arrival counts.
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

    /// Goes on from a transition that was reached to its twin: the foot is set down, and carries
    /// the robot.
    fn set_down(&mut self, problem: &SequenceProblem<'_>, node: TransitionId) {
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

    /// Records that a transition's stance was reached, if that is the first arrival there or not
    /// only the first one counts.
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

    /// Lets a transition that was reached wait until it is the nearest arrival.
    fn enqueue(&mut self, node: TransitionId) {
        let (cost, count) = self.arrivals[node as usize].cost();
        self.heap.push(node, cost, count);
    }

    fn may_use(&self, problem: &SequenceProblem<'_>, foothold: FootholdId) -> bool {
        let station = problem.stations[foothold as usize];
        let is_near = problem.range[0] <= station && station <= problem.range[1];
        is_near
            && (problem.objective != Objective::FewerSteps
                || self.stances[foothold as usize].is_used)
    }

    /// Records a cheaper way to a transition, if it is one.
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

/// Writes the way that leads to a goal.
fn trace(arrivals: &LazilyFilled<Arrival>, goal: TransitionId, sequence: &mut Vec<TransitionId>) {
    let before = |at: &TransitionId| Some(arrivals[*at as usize].from).filter(|from| from != at);
    sequence.extend(std::iter::successors(Some(goal), before));
    sequence.reverse();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};
    use crate::constraints::foothold::Foothold;
    use crate::motion::edge_table::EdgeRecord;
    use crate::motion::mode_graph::TransitionPrior;
    use crate::robot::configuration::Configuration;
    use glam::{DQuat, DVec3};
    use surefoot_shared_types::Pose;
    use surefoot_shared_types::base::limits::JOINTS_MAX;

    /// A straight walk: left soles and right ones at these places along it (m), each pair within
    /// `reach` (m) connected.
    struct Line {
        graph: ModeGraph,
        edges: EdgeTable,
        modes: ModeCosts,
        stations: Vec<u32>,
        ends: [[FootholdId; 2]; 2],
    }

    impl Line {
        fn new(places: &[f64], reach: f64) -> Self {
            let count = 2 * places.len();
            let mut graph = ModeGraph::new(count, count * count, count * count, reach);
            let foothold = |limb, x: f64| {
                let y = if limb == 0 { 0.05 } else { -0.05 };
                Foothold::new(
                    limb,
                    Pose::from_parts(DVec3::new(x, y, 0.0), DQuat::IDENTITY),
                    heapless::Vec::new(),
                )
            };
            for &x in places {
                for limb in [0, 1] {
                    graph.add_foothold(foothold(limb, x)).unwrap();
                }
            }
            for left in (0..count as u32).step_by(2) {
                for right in (1..count as u32).step_by(2) {
                    let [a, b] = [left, right].map(|id| graph.footholds()[id as usize].clone());
                    if a.distance(&b) <= reach {
                        graph.connect(left, right).unwrap();
                    }
                }
            }
            let last = count as u32 - 2;
            let modes = ModeCosts::new(count, count * count, count * count);
            Self {
                graph,
                edges: EdgeTable::new(256),
                modes,
                stations: vec![0; count],
                ends: [[0, 1], [last, last + 1]],
            }
        }

        fn problem<'a>(
            &'a self,
            starts: &'a [TransitionId],
            objective: Objective,
            goal: [FootholdId; 2],
        ) -> SequenceProblem<'a> {
            SequenceProblem {
                graph: &self.graph,
                edges: &self.edges,
                modes: &self.modes,
                objective,
                stations: &self.stations,
                range: [0, 0],
                ends: [TransitionId::MAX, TransitionId::MAX - 1],
                starts,
                goal,
            }
        }

        fn starts(&self, [left, right]: [FootholdId; 2]) -> Vec<TransitionId> {
            [self.graph.find(left, right), self.graph.find(right, left)]
                .into_iter()
                .flatten()
                .collect()
        }

        fn searched(&self, problem: &SequenceProblem<'_>) -> SequenceSearch {
            let mut search =
                SequenceSearch::new(self.stations.len(), self.graph.transitions().len());
            search.begin(problem);
            while search.advance(problem, 1) == 1 {}
            search
        }

        fn cheapest(&self) -> (Vec<TransitionId>, f64) {
            let starts = self.starts(self.ends[0]);
            let problem = self.problem(&starts, Objective::Feasible, self.ends[1]);
            let search = self.searched(&problem);
            assert!(search.has_found());
            let nodes = search.sequence();
            let penalties: f64 =
                nodes.windows(2).map(|pair| problem.penalty(pair[0], pair[1])).sum();
            (nodes.to_vec(), penalties + nodes.iter().map(|&id| problem.cost(id)).sum::<f64>())
        }

        fn longest_step(&self, sequence: &[TransitionId]) -> f64 {
            sequence
                .iter()
                .map(|&id| self.graph.transitions()[id as usize].distance)
                .fold(0.0, f64::max)
        }
    }

    #[test]
    fn moderate_steps_are_cheaper_than_few_long_ones() {
        let line = Line::new(&[0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2], 0.7);
        let (sequence, _) = line.cheapest();
        assert!(
            line.longest_step(&sequence) < 0.3,
            "steps of 0.6 m are there to be had, and are not taken"
        );
    }

    #[test]
    fn where_there_is_no_sequence_either_end_reaches_its_own_side() {
        let line = Line::new(&[0.0, 0.2, 0.4, 1.4, 1.6], 0.5);
        let [start, goal] = line.ends;
        for (objective, from, to, side) in
            [(Objective::Feasible, start, goal, 0..6), (Objective::FromGoal, goal, start, 6..10)]
        {
            let starts = line.starts(from);
            let search = line.searched(&line.problem(&starts, objective, to));
            let mut expanded = search.expanded().to_vec();
            expanded.sort_unstable();
            assert!(
                !search.has_found() && expanded == side.collect::<Vec<FootholdId>>(),
                "{objective:?}: {expanded:?}"
            );
        }
    }

    #[test]
    fn estimates_of_the_cheapest_sequences_suffice_to_find_the_cheapest() {
        let places: Vec<f64> = (0..12).map(|index| 0.1 * f64::from(index)).collect();
        for seed in 0..40 {
            let prior = |id: TransitionId| TransitionPrior {
                attempts: 0,
                extra_attempts: Random::new(seed, Stream::Transition, id.into(), 0).below(9) as u32,
            };
            let (mut all, mut some) = (Line::new(&places, 0.45), Line::new(&places, 0.45));
            let ids = 0..all.graph.transitions().len() as TransitionId;
            ids.clone().for_each(|id| all.graph.record_prior(id, prior(id)));
            let mut estimated = 0;
            while let Some(id) =
                some.cheapest().0.into_iter().find(|&id| some.graph.is_unestimated(id))
            {
                some.graph.record_prior(id, prior(id));
                estimated += 1;
            }
            assert!(
                (some.cheapest().1 - all.cheapest().1).abs() < 1e-12 && estimated < ids.len(),
                "{estimated} of {} estimated",
                ids.len()
            );
        }
    }

    /// What the cheapest sequence costs, by relaxing all swings of all transitions until nothing
    /// changes.
    fn least_cost(problem: &SequenceProblem<'_>) -> f64 {
        let ids = 0..problem.graph.transitions().len() as TransitionId;
        let mut costs = vec![f64::INFINITY; ids.len()];
        problem.starts.iter().for_each(|&start| costs[start as usize] = problem.cost(start));
        let mut has_changed = true;
        while std::mem::take(&mut has_changed) {
            for from in ids.clone() {
                let stance = problem.graph.transitions()[from as usize].stance;
                for to in problem
                    .graph
                    .from_stance(stance)
                    .filter(|&to| to != from)
                    .chain([ModeGraph::twin(from)])
                {
                    let cost = costs[from as usize] + problem.penalty(from, to) + problem.cost(to);
                    if cost < costs[to as usize] - 1e-12 {
                        (costs[to as usize], has_changed) = (cost, true);
                    }
                }
            }
        }
        ids.filter(|&id| problem.is_goal(id))
            .map(|id| costs[id as usize])
            .fold(f64::INFINITY, f64::min)
    }

    /// Lets attempts at transitions fail, others be found, and motions fail on two of three
    /// placements.
    fn try_at_random(line: &mut Line, seed: u64) {
        let mut random = Random::new(seed, Stream::Transition, 0, 0);
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        let count = line.graph.transitions().len();
        for _ in 0..5 * count {
            let id = random.below(count) as TransitionId;
            let stance = line.graph.transitions()[id as usize].stance;
            let swings: Vec<TransitionId> = line.graph.from_stance(stance).collect();
            match random.below(8) {
                0 => line.graph.record_failures(id, random.below(40) as u32),
                1 => line.graph.record_found(id, configuration).unwrap(),
                _ if (u64::from(stance) + seed).is_multiple_of(3) => {}
                _ => {
                    let to =
                        [swings[random.below(swings.len())], ModeGraph::twin(id)][random.below(2)];
                    if line.edges.set(id, to, EdgeRecord { failures: 1, motion: None }).is_ok() {
                        line.graph.record_failed_motion(id, to);
                    }
                }
            }
        }
    }

    #[test]
    fn no_sequence_is_cheaper_after_random_failures() {
        let places: Vec<f64> = (0..5).map(|index| 0.25 * f64::from(index)).collect();
        for seed in 0..1000 {
            let mut line = Line::new(&places, 0.6);
            try_at_random(&mut line, seed);
            let starts = line.starts(line.ends[0]);
            let least = least_cost(&line.problem(&starts, Objective::Feasible, line.ends[1]));
            let (_, cost) = line.cheapest();
            assert!((cost - least).abs() < 1e-9, "seed {seed}: {cost}, {least} is to be had");
        }
    }

    #[test]
    fn costs_are_those_of_the_thesis() {
        let mut line = Line::new(&[0.0, 0.3], 0.5);
        let (sequence, cost) = line.cheapest();
        let distances: Vec<f64> =
            line.graph.transitions().iter().map(|transition| transition.distance).collect();
        let cubed = |id: &TransitionId| distances[*id as usize].powi(3);
        assert!((cost - sequence.iter().map(cubed).sum::<f64>()).abs() < 1e-12, "S(T) starts at 1");
        let (first, second) = (sequence[0], sequence[1]);
        line.graph.record_failures(first, 4);
        assert!(
            (line.graph.transitions()[first as usize].cost() - 5.0 * cubed(&first)).abs() < 1e-12,
            "S(T) D^3(T)"
        );
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        for &id in &sequence {
            line.graph.record_found(id, configuration).unwrap();
        }
        assert_eq!(line.cheapest(), (sequence, 0.0), "what is found costs nothing");
        line.edges.set(first, second, EdgeRecord { failures: 1, motion: None }).unwrap();
        line.graph.record_failed_motion(first, second);
        let (_, cost) = line.cheapest();
        assert!(cost > 0.0 && cost <= SINGLE_MODE_PENALTY, "the penalty p, or what avoids it");
    }
}
