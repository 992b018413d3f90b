//! What the modes cost in single-mode planning: S(sigma), Z(T, sigma) and the cost of a transition
//! [Grey 4.4.3].
//!
//! A transition joins two modes: that of its stance foot alone and that of both its feet. Costs
//! lead the search to the modes that may close the gap between what hangs together with the start
//! and what with the goal, and away from those where it has laboured without success.

use crate::base::arena::{LazilyFilled, filled, reserve};
use crate::base::capacity::ArenaFull;
use crate::motion::mode_graph::{FootholdId, ModeGraph, TransitionId, boundary_of};

/// A mode: one placement carries the robot, or the two of a transition and its twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeId {
    /// On one foot.
    Single(FootholdId),
    /// On both; the lesser of the two transitions between them.
    Double(TransitionId),
}

impl ModeId {
    /// The two modes that a transition joins.
    pub fn of(graph: &ModeGraph, id: TransitionId) -> [Self; 2] {
        [
            Self::Single(graph.transitions()[id as usize].stance),
            Self::Double(id.min(ModeGraph::twin(id))),
        ]
    }
}

/// What is known of a mode.
#[derive(Debug, Clone, Copy)]
struct ModeRecord {
    /// S(sigma): one more than the attempts to extend trees within it.
    attempts: u32,
    /// Whether it holds a configuration that hangs together with the start, with the goal.
    is_connected: [bool; 2],
}

const UNTRIED: ModeRecord = ModeRecord { attempts: 1, is_connected: [false; 2] };

/// What is known of a transition with a configuration.
#[derive(Debug, Clone, Copy, Default)]
struct TransitionRecord {
    /// Whether a motion leads to it within the mode of its stance foot, within that of both.
    is_joined: [bool; 2],
    /// Whether it hangs together with the start, with the goal.
    is_connected_to: [bool; 2],
}

/// The costs, with arenas allocated once.
#[derive(Debug)]
pub struct ModeCosts {
    singles: Vec<ModeRecord>,
    doubles: LazilyFilled<ModeRecord>,
    transitions: LazilyFilled<TransitionRecord>,
    /// Transitions with a configuration.
    found: Vec<TransitionId>,
    /// Motions found, in order; the ends may be boundaries.
    motions: Vec<[TransitionId; 2]>,
}

impl ModeCosts {
    /// Arenas of these capacities.
    pub fn new(footholds_max: usize, transitions_max: usize, configurations_max: usize) -> Self {
        Self {
            singles: filled(UNTRIED, footholds_max),
            doubles: LazilyFilled::new(UNTRIED, transitions_max.div_ceil(2)),
            transitions: LazilyFilled::new(TransitionRecord::default(), transitions_max),
            found: reserve(configurations_max),
            motions: reserve(4 * configurations_max),
        }
    }

    /// Records that a transition has a configuration now. There is room for as many as the graph
    /// has.
    pub fn add_found(&mut self, id: TransitionId) {
        self.found.push(id);
    }

    /// Records a motion between two neighbours in a mode: transitions, or a transition and a
    /// boundary.
    ///
    /// # Errors
    /// There are too many.
    pub fn add_motion(
        &mut self,
        ends: [TransitionId; 2],
        is_double: bool,
    ) -> Result<(), ArenaFull> {
        if self.motions.len() == self.motions.capacity() {
            return Err(ArenaFull::Edges);
        }
        self.motions.push(ends);
        for id in ends.into_iter().filter(|&id| boundary_of(id).is_none()) {
            self.transitions[id as usize].is_joined[usize::from(is_double)] = true;
        }
        Ok(())
    }

    /// Records a search within a mode that failed after so many attempts to extend its trees.
    pub fn add_attempts(&mut self, mode: ModeId, extensions: u32) {
        self.record_mut(mode).attempts += extensions;
    }

    /// S(sigma).
    pub fn attempts(&self, mode: ModeId) -> u32 {
        self.record(mode).attempts
    }

    /// Finds anew what hangs together with the start and with the goal: the nodes of two
    /// boundaries.
    pub fn update_connections(&mut self, graph: &ModeGraph, ends: [TransitionId; 2]) {
        for index in 0..self.found.len() {
            let id = self.found[index];
            self.transitions[id as usize].is_connected_to = [false; 2];
            ModeId::of(graph, id)
                .into_iter()
                .for_each(|mode| self.record_mut(mode).is_connected = [false; 2]);
        }
        for (side, end) in ends.into_iter().enumerate() {
            while self.propagate_once(side, end) {}
        }
        for index in 0..self.found.len() {
            let id = self.found[index];
            let is_connected_to = self.transitions[id as usize].is_connected_to;
            for mode in ModeId::of(graph, id) {
                let is_connected = &mut self.record_mut(mode).is_connected;
                *is_connected = [0, 1].map(|side| is_connected[side] | is_connected_to[side]);
            }
        }
    }

    /// Carries what leads to an end over every motion once; whether that reached anything new.
    fn propagate_once(&mut self, side: usize, end: TransitionId) -> bool {
        let transitions = &mut self.transitions;
        let leads = |transitions: &LazilyFilled<TransitionRecord>, id: TransitionId| {
            match boundary_of(id) {
                Some(_) => id == end,
                None => transitions[id as usize].is_connected_to[side],
            }
        };
        let mut is_new = false;
        // Forth and back, since walks are found in order.
        for &[a, b] in self.motions.iter().chain(self.motions.iter().rev()) {
            for (from, to) in [(a, b), (b, a)] {
                if boundary_of(to).is_none() && leads(transitions, from) && !leads(transitions, to)
                {
                    transitions[to as usize].is_connected_to[side] = true;
                    is_new = true;
                }
            }
        }
        is_new
    }

    /// Z(T, sigma): whether T hangs together with the start or the goal through the mode, and the
    /// mode holds nothing of the other. As of the last [`ModeCosts::update_connections`].
    pub fn is_free(&self, id: TransitionId, mode: ModeId) -> bool {
        let TransitionRecord { is_joined, is_connected_to } = self.transitions[id as usize];
        let is_through = is_joined[usize::from(matches!(mode, ModeId::Double(_)))];
        is_through && is_connected_to != [false; 2] && self.record(mode).is_connected != [true; 2]
    }

    /// c(T, sigma): nothing where Z holds, else S(sigma).
    pub fn mode_cost(&self, id: TransitionId, mode: ModeId) -> f64 {
        if self.is_free(id, mode) { 0.0 } else { f64::from(self.attempts(mode)) }
    }

    /// C(T) of the transition between two modes: D^3 times what both cost, m^3.
    pub fn cost(&self, graph: &ModeGraph, id: TransitionId) -> f64 {
        let mode_costs = ModeId::of(graph, id).map(|mode| self.mode_cost(id, mode));
        graph.transitions()[id as usize].cubed_distance() * (mode_costs[0] + mode_costs[1])
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.singles.len() * size_of::<ModeRecord>()
            + self.doubles.bytes()
            + self.transitions.bytes()
            + self.found.capacity() * size_of::<TransitionId>()
            + self.motions.capacity() * size_of::<[TransitionId; 2]>()
    }

    fn record(&self, mode: ModeId) -> &ModeRecord {
        match mode {
            ModeId::Single(stance) => &self.singles[stance as usize],
            ModeId::Double(id) => &self.doubles[id as usize / 2],
        }
    }

    fn record_mut(&mut self, mode: ModeId) -> &mut ModeRecord {
        match mode {
            ModeId::Single(stance) => &mut self.singles[stance as usize],
            ModeId::Double(id) => &mut self.doubles[id as usize / 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::foothold::Foothold;
    use crate::motion::mode_graph::{GOAL, START, boundary_node};
    use crate::robot::configuration::Configuration;
    use glam::{DQuat, DVec3};
    use surefoot_shared_types::Pose;
    use surefoot_shared_types::base::limits::JOINTS_MAX;

    const ENDS: usize = 5;

    /// Figures 4.16 and 4.17: mode sigma_0, one foot on its placement, and transitions T_0^1,
    /// T_0^2, ... to other modes.
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
            let configuration =
                Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
            for index in 1..=ENDS {
                let other = graph.add_foothold(foothold(1, 0.1 * index as f64)).unwrap();
                graph.connect(stance, other).unwrap();
                graph.record_found(Self::transition(index), configuration).unwrap();
                costs.add_found(Self::transition(index));
            }
            Self { graph, costs }
        }

        /// T_0^index: all weight on the placement of sigma_0.
        fn transition(index: usize) -> TransitionId {
            2 * (index - 1) as TransitionId
        }

        fn joined_in_sigma_0(mut self, a: usize, b: usize) -> Self {
            self.costs.add_motion([a, b].map(Self::transition), false).unwrap();
            self
        }

        fn connected_to_boundary(mut self, boundary: usize, index: usize) -> Self {
            self.costs
                .add_motion([boundary_node(boundary), Self::transition(index)], true)
                .unwrap();
            self
        }

        /// The transitions that cost nothing on the side of sigma_0.
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
    fn figure_4_16_a_what_the_start_reaches_through_the_mode_is_free() {
        assert_eq!(
            Figure::new().connected_to_boundary(START, 1).joined_in_sigma_0(1, 2).free(),
            [1, 2]
        );
    }

    #[test]
    fn figure_4_16_b_so_is_what_the_goal_reaches_through_it() {
        assert_eq!(
            Figure::new().connected_to_boundary(GOAL, 3).joined_in_sigma_0(2, 3).free(),
            [2, 3]
        );
    }

    #[test]
    fn figure_4_16_c_nothing_is_free_where_the_mode_holds_both_trees() {
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
    fn figure_4_17_trees_of_neither_end_are_not_free() {
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
    fn a_transition_costs_what_both_its_modes_have_been_laboured_at() {
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
}
