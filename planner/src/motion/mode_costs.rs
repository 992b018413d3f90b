//! The costs of modes in single-mode planning: S(sigma), Z(T, sigma) and the transition cost
//! [Grey 4.4.3].
//!
//! A transition joins two modes: single support on its stance foot, and double support. The costs
//! direct the search to modes that may connect the tree of the start with that of the goal, and
//! away from modes with many failed attempts.

use crate::base::arena::{LazilyFilled, filled, reserve};
use crate::base::capacity::ArenaFull;
use crate::motion::ids::{FootholdId, TransitionId, boundary_of};
use crate::motion::mode_graph::ModeGraph;

/// A mode: single support on a foothold, or double support on those of a transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeId {
    /// Single support.
    Single(FootholdId),
    /// Double support; the lesser index of the transition and its twin.
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

/// State of a mode.
#[derive(Debug, Clone, Copy)]
struct ModeRecord {
    /// S(sigma): one more than the tree extensions of failed searches within it.
    attempts: u32,
    /// Whether it holds a configuration that is connected to the start, and one to the goal.
    is_connected: [bool; 2],
}

/// A mode without attempts.
const UNTRIED: ModeRecord = ModeRecord { attempts: 1, is_connected: [false; 2] };

/// State of a transition with a configuration.
#[derive(Debug, Clone, Copy, Default)]
struct TransitionRecord {
    /// Whether a motion leads to it in single support, and in double support.
    is_joined: [bool; 2],
    /// Whether it is connected to the start, and to the goal.
    is_connected_to: [bool; 2],
}

/// The costs of all modes, in arenas allocated once.
#[derive(Debug)]
pub struct ModeCosts {
    singles: Vec<ModeRecord>,
    doubles: LazilyFilled<ModeRecord>,
    transitions: LazilyFilled<TransitionRecord>,
    /// Transitions with a configuration.
    found: Vec<TransitionId>,
    /// The ends of the motions found, in order; they may be boundary nodes.
    motions: Vec<[TransitionId; 2]>,
}

impl ModeCosts {
    /// Arenas of these capacities. Allocates.
    pub fn new(footholds_max: usize, transitions_max: usize, configurations_max: usize) -> Self {
        Self {
            singles: filled(UNTRIED, footholds_max),
            doubles: LazilyFilled::new(UNTRIED, transitions_max.div_ceil(2)),
            transitions: LazilyFilled::new(TransitionRecord::default(), transitions_max),
            found: reserve(configurations_max),
            motions: reserve(4 * configurations_max),
        }
    }

    /// Records that a transition has a configuration. The capacity is that of the graph.
    pub fn add_found(&mut self, id: TransitionId) {
        self.found.push(id);
    }

    /// Records a motion within a mode between two transitions, or a transition and a boundary node.
    ///
    /// # Errors
    /// The arena of motions is full.
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

    /// Records a failed search within a mode and its number of tree extensions.
    pub fn add_attempts(&mut self, mode: ModeId, extensions: u32) {
        self.record_mut(mode).attempts += extensions;
    }

    /// S(sigma) of a mode.
    pub fn attempts(&self, mode: ModeId) -> u32 {
        self.record(mode).attempts
    }

    /// Updates which transitions and modes are connected to the start and to the goal, given as two
    /// boundary nodes.
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

    /// Propagates the connection to an end over every motion once. Returns whether it reached a
    /// transition that was not connected.
    fn propagate_once(&mut self, side: usize, end: TransitionId) -> bool {
        let transitions = &mut self.transitions;
        let is_connected = |transitions: &LazilyFilled<TransitionRecord>, id: TransitionId| {
            match boundary_of(id) {
                Some(_) => id == end,
                None => transitions[id as usize].is_connected_to[side],
            }
        };
        let mut has_changed = false;
        // In both directions, because the motions of a walk are found in order.
        for &[a, b] in self.motions.iter().chain(self.motions.iter().rev()) {
            for (from, to) in [(a, b), (b, a)] {
                if boundary_of(to).is_none()
                    && is_connected(transitions, from)
                    && !is_connected(transitions, to)
                {
                    transitions[to as usize].is_connected_to[side] = true;
                    has_changed = true;
                }
            }
        }
        has_changed
    }

    /// Z(T, sigma): whether T is connected to the start or the goal through the mode, while the
    /// mode is not connected to both. As of the last [`ModeCosts::update_connections`].
    pub fn is_free(&self, id: TransitionId, mode: ModeId) -> bool {
        let TransitionRecord { is_joined, is_connected_to } = self.transitions[id as usize];
        let is_through = is_joined[usize::from(matches!(mode, ModeId::Double(_)))];
        is_through && is_connected_to != [false; 2] && self.record(mode).is_connected != [true; 2]
    }

    /// c(T, sigma): 0 if Z holds, else S(sigma).
    pub fn mode_cost(&self, id: TransitionId, mode: ModeId) -> f64 {
        if self.is_free(id, mode) { 0.0 } else { f64::from(self.attempts(mode)) }
    }

    /// C(T) of the transition between two modes: D^3 times the sum of their costs, m^3.
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
mod tests;
