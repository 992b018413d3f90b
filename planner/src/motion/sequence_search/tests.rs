//! Sequences over synthetic graphs of footholds along a line.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::base::random::{Random, Stream};
use crate::constraints::foothold::Foothold;
use crate::motion::edge_table::{EdgeRecord, EdgeTable};
use crate::motion::ids::{FootholdId, TransitionId};
use crate::motion::mode_costs::ModeCosts;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::sequence_search::SequenceSearch;
use crate::motion::transition::TransitionPrior;
use crate::motion::transition_sequence::{Objective, SequenceProblem};
use crate::motion::tuning::SINGLE_MODE_PENALTY;
use crate::robot::configuration::Configuration;

/// Left and right footholds at positions along a straight line (m); pairs within `reach` (m) are
/// connected.
struct Line {
    graph: ModeGraph,
    edges: EdgeTable,
    modes: ModeCosts,
    nearest_vertices: Vec<u32>,
    ends: [[FootholdId; 2]; 2],
}

impl Line {
    fn new(positions: &[f64], reach: f64) -> Self {
        let count = 2 * positions.len();
        let mut graph = ModeGraph::new(count, count * count, count * count, reach);
        let foothold = |limb, x: f64| {
            let y = if limb == 0 { 0.05 } else { -0.05 };
            Foothold::new(
                limb,
                Pose::from_parts(DVec3::new(x, y, 0.0), DQuat::IDENTITY),
                heapless::Vec::new(),
            )
        };
        for &x in positions {
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
            nearest_vertices: vec![0; count],
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
            nearest_vertices: &self.nearest_vertices,
            vertex_range: [0, 0],
            ends: [TransitionId::MAX, TransitionId::MAX - 1],
            starts,
            goal,
        }
    }

    fn starts(&self, [left, right]: [FootholdId; 2]) -> Vec<TransitionId> {
        self.graph.find_all(left, right).chain(self.graph.find_all(right, left)).collect()
    }

    /// A search that has ended.
    fn searched(&self, problem: &SequenceProblem<'_>) -> SequenceSearch {
        let mut search =
            SequenceSearch::new(self.nearest_vertices.len(), self.graph.transitions().len());
        search.begin(problem);
        while search.advance(problem, 1) == 1 {}
        search
    }

    /// The cheapest sequence and its cost, m^3.
    fn cheapest(&self) -> (Vec<TransitionId>, f64) {
        let starts = self.starts(self.ends[0]);
        let problem = self.problem(&starts, Objective::Feasible, self.ends[1]);
        let search = self.searched(&problem);
        assert!(search.has_found());
        let nodes = search.sequence();
        let penalties: f64 = nodes.windows(2).map(|pair| problem.penalty(pair[0], pair[1])).sum();
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
    assert!(line.longest_step(&sequence) < 0.3, "steps of 0.6 m exist and are not taken");
}

#[test]
fn without_a_sequence_each_end_expands_the_footholds_of_its_own_side() {
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
fn priors_of_the_cheapest_sequences_suffice_to_find_the_cheapest() {
    let positions: Vec<f64> = (0..12).map(|index| 0.1 * f64::from(index)).collect();
    for seed in 0..40 {
        let prior = |id: TransitionId| TransitionPrior {
            attempts: 0,
            extra_attempts: Random::new(seed, Stream::Transition, id.into(), 0).below(9) as u32,
        };
        let (mut all, mut some) = (Line::new(&positions, 0.45), Line::new(&positions, 0.45));
        let ids = 0..all.graph.transitions().len() as TransitionId;
        ids.clone().for_each(|id| all.graph.record_prior(id, prior(id)));
        let mut estimated = 0;
        while let Some(id) = some.cheapest().0.into_iter().find(|&id| some.graph.is_unestimated(id))
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

/// Cost of the cheapest sequence, by relaxing all swings of all transitions until nothing changes
/// (Bellman-Ford), m^3.
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
                .of_stance(stance)
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
    ids.filter(|&id| problem.is_goal(id)).map(|id| costs[id as usize]).fold(f64::INFINITY, f64::min)
}

/// Records random failures and configurations of transitions, and failed motions on two of three
/// footholds.
fn record_at_random(line: &mut Line, seed: u64) {
    let mut random = Random::new(seed, Stream::Transition, 0, 0);
    let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
    let count = line.graph.transitions().len();
    for _ in 0..5 * count {
        let id = random.below(count) as TransitionId;
        let stance = line.graph.transitions()[id as usize].stance;
        let swings: Vec<TransitionId> = line.graph.of_stance(stance).collect();
        match random.below(8) {
            0 => line.graph.record_failures(id, random.below(40) as u32),
            1 => line.graph.record_found(id, configuration).unwrap(),
            _ if (u64::from(stance) + seed).is_multiple_of(3) => {}
            _ => {
                let to = [swings[random.below(swings.len())], ModeGraph::twin(id)][random.below(2)];
                if line.edges.set(id, to, EdgeRecord { failures: 1, motion: None }).is_ok() {
                    line.graph.record_failed_motion(id, to);
                }
            }
        }
    }
}

#[test]
fn no_sequence_is_cheaper_after_random_failures() {
    let positions: Vec<f64> = (0..5).map(|index| 0.25 * f64::from(index)).collect();
    for seed in 0..1000 {
        let mut line = Line::new(&positions, 0.6);
        record_at_random(&mut line, seed);
        let starts = line.starts(line.ends[0]);
        let least = least_cost(&line.problem(&starts, Objective::Feasible, line.ends[1]));
        let (_, cost) = line.cheapest();
        assert!((cost - least).abs() < 1e-9, "seed {seed}: cost {cost}, least {least}");
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
    assert_eq!(line.cheapest(), (sequence, 0.0), "transitions with a configuration cost nothing");
    line.edges.set(first, second, EdgeRecord { failures: 1, motion: None }).unwrap();
    line.graph.record_failed_motion(first, second);
    let (_, cost) = line.cheapest();
    assert!(
        cost > 0.0 && cost <= SINGLE_MODE_PENALTY,
        "the penalty p, or the cost of another sequence"
    );
}

#[test]
fn other_configurations_on_the_same_footholds_replace_a_failed_motion() {
    let mut line = Line::new(&[0.0, 0.3], 0.5);
    let (sequence, _) = line.cheapest();
    let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
    let known = line.graph.transitions().len() as TransitionId;
    for id in 0..known {
        line.graph.record_failures(id, 1_000);
    }
    for &id in &sequence {
        line.graph.record_found(id, configuration).unwrap();
    }
    let (from, to) = (sequence[0], sequence[1]);
    line.edges.set(from, to, EdgeRecord { failures: 9, motion: None }).unwrap();
    line.graph.record_failed_motion(from, to);
    assert!(line.cheapest().1 > 1.0, "no walk is left");
    line.graph.add_alternative(from).unwrap();
    let added = known..line.graph.transitions().len() as TransitionId;
    for id in added.clone() {
        assert!(
            !line.graph.is_unestimated(id) && line.graph.transitions()[id as usize].attempts > 12
        );
        line.graph.record_found(id, configuration).unwrap();
    }
    let (other, cost) = line.cheapest();
    let pair = |id: TransitionId| {
        let transition = &line.graph.transitions()[id as usize];
        (transition.stance, transition.other)
    };
    assert_eq!(cost, 0.0);
    assert!(added.contains(&other[0]) && pair(other[0]) == pair(from), "{other:?}");
}
