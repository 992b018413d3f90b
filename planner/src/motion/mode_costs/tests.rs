//! The figures of the thesis on a small graph.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::constraints::foothold::Foothold;
use crate::motion::ids::{GOAL, START, TransitionId, boundary_node};
use crate::motion::mode_costs::{ModeCosts, ModeId};
use crate::motion::mode_graph::ModeGraph;
use crate::robot::configuration::Configuration;

const ENDS: usize = 5;

/// Figures 4.16 and 4.17: mode sigma_0 in single support, and transitions T_0^1, T_0^2, ... to
/// other modes.
struct Figure {
    graph: ModeGraph,
    costs: ModeCosts,
}

impl Figure {
    fn new() -> Self {
        let mut graph = ModeGraph::new(1 + ENDS, 2 * ENDS, 2 * ENDS, 1.0);
        let mut costs = ModeCosts::new(1 + ENDS, 2 * ENDS, 2 * ENDS);
        let foothold = |limb, x| {
            Foothold::new(
                limb,
                Pose::from_parts(DVec3::X * x, DQuat::IDENTITY),
                heapless::Vec::new(),
            )
        };
        let stance = graph.add_foothold(foothold(0, 0.0)).unwrap();
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        for index in 1..=ENDS {
            let other = graph.add_foothold(foothold(1, 0.1 * index as f64)).unwrap();
            graph.connect(stance, other).unwrap();
            graph.record_found(Self::transition(index), configuration).unwrap();
            costs.add_found(Self::transition(index));
        }
        Self { graph, costs }
    }

    /// T_0^index, whose stance foothold is that of sigma_0.
    fn transition(index: usize) -> TransitionId {
        2 * (index - 1) as TransitionId
    }

    fn joined_in_sigma_0(mut self, a: usize, b: usize) -> Self {
        self.costs.add_motion([a, b].map(Self::transition), false).unwrap();
        self
    }

    fn connected_to_boundary(mut self, boundary: usize, index: usize) -> Self {
        self.costs.add_motion([boundary_node(boundary), Self::transition(index)], true).unwrap();
        self
    }

    /// The transitions with cost 0 on the side of sigma_0.
    fn free(&mut self) -> Vec<usize> {
        self.costs.update_connections(&self.graph, [START, GOAL].map(boundary_node));
        (1..=ENDS)
            .filter(|&index| {
                self.costs.mode_cost(Self::transition(index), ModeId::Single(0)) == 0.0
            })
            .collect()
    }
}

#[test]
fn figure_4_16_a_transitions_connected_to_the_start_through_the_mode_are_free() {
    assert_eq!(
        Figure::new().connected_to_boundary(START, 1).joined_in_sigma_0(1, 2).free(),
        [1, 2]
    );
}

#[test]
fn figure_4_16_b_transitions_connected_to_the_goal_through_the_mode_are_free() {
    assert_eq!(Figure::new().connected_to_boundary(GOAL, 3).joined_in_sigma_0(2, 3).free(), [2, 3]);
}

#[test]
fn figure_4_16_c_no_transition_is_free_in_a_mode_connected_to_both_ends() {
    let apart = Figure::new()
        .connected_to_boundary(START, 1)
        .joined_in_sigma_0(1, 2)
        .connected_to_boundary(GOAL, 4);
    assert!(apart.joined_in_sigma_0(3, 4).free().is_empty());
    assert!(
        Figure::new()
            .connected_to_boundary(START, 1)
            .joined_in_sigma_0(1, 2)
            .connected_to_boundary(GOAL, 4)
            .free()
            .is_empty(),
        "a root is a tree too"
    );
}

#[test]
fn figure_4_17_transitions_connected_to_neither_end_are_not_free() {
    assert!(Figure::new().joined_in_sigma_0(1, 2).free().is_empty());
    assert_eq!(
        Figure::new()
            .connected_to_boundary(START, 1)
            .joined_in_sigma_0(1, 2)
            .joined_in_sigma_0(3, 4)
            .free(),
        [1, 2]
    );
}

#[test]
fn figure_4_17_a_transition_is_free_only_through_the_mode_that_joins_it() {
    let mut figure = Figure::new().connected_to_boundary(START, 1);
    assert!(figure.free().is_empty());
    assert!(figure.costs.is_free(Figure::transition(1), ModeId::Double(Figure::transition(1))));
}

#[test]
fn the_cost_of_a_transition_counts_the_attempts_in_both_its_modes() {
    let mut figure = Figure::new().connected_to_boundary(START, 1);
    figure.free();
    let (stance, costs) = (ModeId::Single(0), &mut figure.costs);
    costs.add_attempts(stance, 6);
    assert_eq!(costs.attempts(stance), 7, "S starts at 1");
    let cubed = |index: usize| (0.1 * index as f64).powi(3);
    assert!(
        (costs.cost(&figure.graph, Figure::transition(1)) - 7.0 * cubed(1)).abs() < 1e-12,
        "free on the side of the start"
    );
    assert!(
        (costs.cost(&figure.graph, Figure::transition(2)) - 8.0 * cubed(2)).abs() < 1e-12,
        "both modes count"
    );
}
