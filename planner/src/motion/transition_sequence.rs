//! The query for the cheapest sequence of transitions, and what transitions cost in it
//! [Grey 4.4.2].

use crate::motion::edge_table::EdgeTable;
use crate::motion::ids::{FootholdId, TransitionId};
use crate::motion::mode_costs::ModeCosts;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::tuning::{FEWER_STEPS_BASE, SINGLE_MODE_PENALTY};

/// What a sequence is optimised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Any walk: C(T), which is 0 for a transition with a configuration [Grey 4.4.2].
    Feasible,
    /// The footholds that walks from the goal back toward the start reach, if no walk connects both
    /// [Grey 4.4.4].
    FromGoal,
    /// The modes to search next, over transitions with a configuration only: costs of their modes
    /// [Grey 4.4.3].
    ConnectModes,
    /// Fewer steps over the footholds of a walk that is known: every transition costs [Grey 4.4.6].
    FewerSteps,
}

/// A query for the cheapest sequence.
#[derive(Debug, Clone, Copy)]
pub struct SequenceProblem<'a> {
    /// Modes and transitions.
    pub graph: &'a ModeGraph,
    /// Failed searches and motions between transitions.
    pub edges: &'a EdgeTable,
    /// Costs of the modes.
    pub modes: &'a ModeCosts,
    /// What the sequence is optimised for.
    pub objective: Objective,
    /// The route vertex nearest to each foothold; a value outside of every range for a foothold
    /// that the route does not use.
    pub nearest_vertices: &'a [u32],
    /// The first and the last route vertex whose footholds the sequence may use.
    pub vertex_range: [u32; 2],
    /// The boundary nodes before and after the sequence.
    pub ends: [TransitionId; 2],
    /// The transitions with which the sequence may begin.
    pub starts: &'a [TransitionId],
    /// The two footholds on which it ends.
    pub goal: [FootholdId; 2],
}

impl SequenceProblem<'_> {
    /// C(T) of a transition under the objective, m^3.
    pub(crate) fn cost(&self, id: TransitionId) -> f64 {
        let transition = &self.graph.transitions()[id as usize];
        match self.objective {
            Objective::Feasible | Objective::FromGoal => transition.cost(),
            Objective::ConnectModes if transition.is_found() => self.modes.cost(self.graph, id),
            Objective::ConnectModes => f64::INFINITY,
            Objective::FewerSteps => FEWER_STEPS_BASE + transition.effort(),
        }
    }

    /// Cost of a swing to a transition and of its twin, which follows it, m^3.
    pub(crate) fn step_cost(&self, to: TransitionId) -> f64 {
        match self.objective {
            Objective::Feasible | Objective::FromGoal => self.graph.step_cost(to),
            Objective::ConnectModes | Objective::FewerSteps => {
                self.cost(to) + self.cost(ModeGraph::twin(to))
            }
        }
    }

    /// Whether a transition stands on the two footholds of the goal.
    pub(crate) fn is_goal(&self, id: TransitionId) -> bool {
        let transition = &self.graph.transitions()[id as usize];
        self.goal.contains(&transition.stance) && self.goal.contains(&transition.other)
    }

    /// Penalty for the failed searches between two transitions, m^3.
    pub(crate) fn penalty(&self, from: TransitionId, to: TransitionId) -> f64 {
        if self.graph.may_have_failed(from, to) { self.failure_cost(from, to) } else { 0.0 }
    }

    /// The same where one of both may be a boundary node.
    pub(crate) fn failure_cost(&self, from: TransitionId, to: TransitionId) -> f64 {
        match self.objective {
            Objective::ConnectModes => 0.0,
            Objective::Feasible | Objective::FromGoal | Objective::FewerSteps => {
                f64::from(self.edges.get(from, to).failures) * SINGLE_MODE_PENALTY
            }
        }
    }
}
