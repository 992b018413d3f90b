//! Gamma_M: the roadmap of stage M [Grey 3.2, 4.4].

use surefoot_shared_types::Pose;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::message::SupportMode;

use crate::base::arena::{ArenaSlice, append_all, reserve, slice_at};
use crate::base::capacity::ArenaFull;
use crate::base::threads::Threads;
use crate::constraints::foothold::{Foothold, Ground, double_mode, left_and_right, single_mode};
use crate::constraints::mode::{Mode, StartBalance};
use crate::constraints::mode_state::ModeState;
use crate::motion::edge_table::{EdgeRecord, EdgeTable};
use crate::motion::ids::{
    BOUNDARIES_MAX, FootholdId, GOAL, START, TransitionId, boundary_node, boundary_of,
};
use crate::motion::mode_costs::{ModeCosts, ModeId};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::transition_sampling::TransitionSampling;
use crate::motion::tree_pool::{TreeKey, TreePool};
use crate::motion::tuning::{MOTIONS_PER_PLAN, TREE_NODES_MAX, TREES_MAX};
use crate::plan::chunk_builder::ModeMotion;
use crate::primitives::transition_pair::TransitionPair;
use crate::robot::configuration::Configuration;

/// The roadmap, allocated once.
#[derive(Debug)]
pub struct Roadmap {
    /// Modes and transitions.
    pub graph: ModeGraph,
    /// Motions between transitions and failed searches for them.
    pub edges: EdgeTable,
    /// Costs of the modes.
    pub costs: ModeCosts,
    /// The trees of single-mode planning.
    pub trees: TreePool,
    boundaries: Vec<Boundary>,
    start_balance: Option<StartBalance>,
    /// Indexed like the configurations of the graph.
    lift_offs: Vec<LiftOffRecord>,
    waypoints: Vec<Configuration>,
}

/// The lift-off of the touched foot of a transition.
#[derive(Debug, Clone, Copy)]
struct LiftOffRecord {
    /// Both sole poses in the world, the foot lifted.
    lifted: [Pose; 2],
    /// The path to that state, in the waypoint arena.
    waypoints: ArenaSlice,
}

/// A rest state on two footholds between two segments, or at the start or the goal.
#[derive(Debug, Clone)]
pub struct Boundary {
    /// The footholds, left and right.
    pub footholds: [FootholdId; 2],
    /// The state of the robot.
    pub state: ModeState,
    /// The feet that carry the weight.
    pub support: SupportMode,
}

/// The transition sequence of a segment and the boundary nodes at both its ends.
#[derive(Debug, Clone, Copy)]
pub struct RouteSegment<'a> {
    /// The transitions.
    pub sequence: &'a [TransitionId],
    /// The nodes before and after them.
    pub ends: [TransitionId; 2],
}

impl RouteSegment<'_> {
    /// Edge `index`; edge 0 leads to the first transition.
    pub fn edge(&self, index: usize) -> ModeEdge {
        let from = if index == 0 { self.ends[0] } else { self.sequence[index - 1] };
        ModeEdge { from, to: self.sequence.get(index).copied().unwrap_or(self.ends[1]) }
    }
}

/// An ordered pair of transitions, or boundary nodes, within one mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeEdge {
    /// The node at its beginning.
    pub from: TransitionId,
    /// The node at its end.
    pub to: TransitionId,
}

impl Roadmap {
    /// Empty arenas of the configured capacities, for steps of at most `reach` (m). Allocates.
    pub fn new(config: &PlannerConfig, reach: f64) -> Self {
        let [footholds_max, transitions_max] =
            [config.footholds_max, config.transitions_max].map(|count| count as usize);
        let [configurations_max, waypoints_max] =
            [config.configurations_max, config.waypoints_max].map(|count| count as usize);
        Self {
            graph: ModeGraph::new(footholds_max, transitions_max, configurations_max, reach),
            edges: EdgeTable::new(4 * configurations_max),
            costs: ModeCosts::new(footholds_max, transitions_max, configurations_max),
            trees: TreePool::new(TREES_MAX, TREE_NODES_MAX),
            boundaries: reserve(BOUNDARIES_MAX),
            start_balance: None,
            lift_offs: reserve(configurations_max),
            waypoints: reserve(MOTIONS_PER_PLAN * waypoints_max),
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.graph.bytes()
            + self.edges.bytes()
            + self.costs.bytes()
            + self.trees.bytes()
            + self.boundaries.capacity() * size_of::<Boundary>()
            + self.lift_offs.capacity() * size_of::<LiftOffRecord>()
            + self.waypoints.capacity() * size_of::<Configuration>()
    }

    /// Stores the waypoints of motions and lift-offs. Returns their slices of the arena.
    ///
    /// # Errors
    /// The waypoint arena cannot hold all of them.
    pub fn store<const N: usize>(
        &mut self,
        paths: &heapless::Vec<&[Configuration], N>,
        threads: &Threads,
    ) -> Result<heapless::Vec<ArenaSlice, N>, ArenaFull> {
        append_all(&mut self.waypoints, paths, threads).ok_or(ArenaFull::Waypoints)
    }

    /// Records the result of sampling a transition. `waypoints` is the path of the lift-off after
    /// the configuration itself.
    ///
    /// # Errors
    /// An arena is full.
    pub fn record_sampling(
        &mut self,
        sampling: &TransitionSampling,
        waypoints: ArenaSlice,
    ) -> Result<(), ArenaFull> {
        self.graph.record_failures(sampling.id, sampling.failed());
        let Some(found) = sampling.found() else { return Ok(()) };
        let lift_off = LiftOffRecord { lifted: found.lifted.world_from_soles, waypoints };
        self.record_found(sampling.id, found.configuration, lift_off)
    }

    /// Records a motion of pi_S between two primitive configurations, unless one of its transitions
    /// has another configuration.
    ///
    /// # Errors
    /// An arena is full.
    pub fn record_primitive(
        &mut self,
        edge: ModeEdge,
        ends: &[ModeState; 2],
        path: ArenaSlice,
    ) -> Result<(), ArenaFull> {
        for (id, state) in [edge.from, edge.to].into_iter().zip(ends) {
            match self.graph.configuration(id) {
                Some(known) if known != &state.configuration => return Ok(()),
                Some(_) => {}
                None => self.record_found(
                    id,
                    state.configuration,
                    LiftOffRecord { lifted: state.world_from_soles, waypoints: (0, 0) },
                )?,
            }
        }
        self.record_motion(edge, path)
    }

    fn record_found(
        &mut self,
        id: TransitionId,
        configuration: Configuration,
        lift_off: LiftOffRecord,
    ) -> Result<(), ArenaFull> {
        self.graph.record_found(id, configuration)?;
        self.costs.add_found(id);
        self.lift_offs.push(lift_off);
        Ok(())
    }

    /// Records the motion found for an edge. `path` holds its waypoints after the first.
    ///
    /// # Errors
    /// An arena is full.
    pub fn record_motion(&mut self, edge: ModeEdge, path: ArenaSlice) -> Result<(), ArenaFull> {
        let failures = self.edges.get(edge.from, edge.to).failures;
        self.edges.set(edge.from, edge.to, EdgeRecord { failures, motion: Some(path) })?;
        self.costs.add_motion([edge.from, edge.to], self.is_double(edge))
    }

    /// Replaces the motion of an edge by a shorter one, whose path includes the first state. Does
    /// nothing if the edge has no motion or the path has more waypoints.
    ///
    /// # Errors
    /// An arena is full.
    pub fn shorten_motion(
        &mut self,
        edge: ModeEdge,
        path: &[Configuration],
    ) -> Result<(), ArenaFull> {
        let record = self.edges.get(edge.from, edge.to);
        let Some((first, _)) = record.motion.filter(|&(_, count)| path.len() <= count as usize + 1)
        else {
            return Ok(());
        };
        let shorter = &path[1..];
        self.waypoints[first as usize..first as usize + shorter.len()].copy_from_slice(shorter);
        self.edges.set(
            edge.from,
            edge.to,
            EdgeRecord { motion: Some((first, shorter.len() as u32)), ..record },
        )
    }

    /// Number of waypoints of all motions and lift-offs.
    pub fn waypoints_len(&self) -> usize {
        self.waypoints.len()
    }

    /// The waypoints after the first of the motion of an edge, if one was found.
    pub fn motion(&self, edge: ModeEdge) -> Option<&[Configuration]> {
        Some(slice_at(&self.waypoints, self.edges.get(edge.from, edge.to).motion?))
    }

    /// Records a failed search for an edge and its number of tree extensions.
    ///
    /// # Errors
    /// An arena is full.
    pub fn record_failure(&mut self, edge: ModeEdge, extensions: u32) -> Result<(), ArenaFull> {
        let failures = self.edges.get(edge.from, edge.to).failures + 1;
        self.edges.set(edge.from, edge.to, EdgeRecord { failures, motion: None })?;
        let transition = if boundary_of(edge.from).is_none() { edge.from } else { edge.to };
        let [single, double] = ModeId::of(&self.graph, transition);
        self.costs.add_attempts(if self.is_double(edge) { double } else { single }, extensions);
        if boundary_of(edge.from).is_none() && boundary_of(edge.to).is_none() {
            self.graph.record_failed_motion(edge.from, edge.to);
        }
        Ok(())
    }

    /// The mode of an edge.
    pub fn mode(&self, edge: ModeEdge) -> Mode {
        let [stance, other] = self.footholds(edge);
        let mode =
            if self.is_double(edge) { double_mode(stance, other) } else { single_mode(stance) };
        let start = self.start_balance.filter(|_| boundary_of(edge.from) == Some(START));
        Mode { start, ..mode }
    }

    /// The state at a transition that has a configuration, or at a boundary node.
    pub fn state(&self, node: TransitionId) -> ModeState {
        if let Some(index) = boundary_of(node) {
            return self.boundaries[index].state;
        }
        let (stance, other) = self.graph.pair(node);
        let world_from_soles = TransitionPair { stance, other }.world_from_soles();
        let configuration =
            *self.graph.configuration(node).unwrap_or(&self.boundaries[START].state.configuration);
        ModeState { configuration, world_from_soles }
    }

    /// The ends of an edge with the swing foot lifted, and the lift-off paths, where known.
    pub fn lifted(&self, edge: ModeEdge) -> [Option<(ModeState, &[Configuration])>; 2] {
        let is_swing = !self.is_double(edge);
        [edge.from, edge.to].map(|node| {
            let index =
                boundary_of(node).is_none().then(|| self.graph.configuration_index(node)).flatten();
            let LiftOffRecord { lifted, waypoints } = self.lift_offs[index.filter(|_| is_swing)?];
            let path = slice_at(&self.waypoints, waypoints);
            Some((ModeState { configuration: *path.last()?, world_from_soles: lifted }, path))
        })
    }

    /// The trees of both ends of an edge.
    pub fn tree_keys(&self, edge: ModeEdge) -> [TreeKey; 2] {
        let is_double = self.is_double(edge);
        [edge.from, edge.to].map(|node| TreeKey { node, is_double })
    }

    /// Sets the balance of the start state.
    pub fn set_start_balance(&mut self, balance: StartBalance) {
        self.start_balance = Some(balance);
    }

    /// Whether the arena of boundaries is full.
    pub fn is_full_of_boundaries(&self) -> bool {
        self.boundaries.len() == BOUNDARIES_MAX
    }

    /// Adds a boundary. Returns its index.
    ///
    /// # Panics
    /// The arena of boundaries is full, see [`Roadmap::is_full_of_boundaries`].
    pub fn add_boundary(&mut self, boundary: Boundary) -> usize {
        assert!(!self.is_full_of_boundaries(), "the arena of boundaries is full");
        self.boundaries.push(boundary);
        self.boundaries.len() - 1
    }

    /// Replaces the state at the goal, unless a motion leads to it. The records of failed motions
    /// to it are forgotten. Returns whether it is replaced.
    ///
    /// # Errors
    /// An arena is full.
    pub fn replace_goal(&mut self, state: ModeState) -> Result<bool, ArenaFull> {
        let [left, right] = self.boundaries[GOAL].footholds;
        let goal = boundary_node(GOAL);
        let before = || self.graph.find_all(left, right).chain(self.graph.find_all(right, left));
        if before().any(|from| self.edges.get(from, goal).motion.is_some()) {
            return Ok(false);
        }
        for from in before() {
            if self.edges.get(from, goal).failures > 0 {
                self.edges.set(from, goal, EdgeRecord::default())?;
            }
        }
        self.trees.forget(goal);
        self.boundaries[GOAL].state = state;
        Ok(true)
    }

    /// Number of boundaries.
    pub fn boundaries_len(&self) -> usize {
        self.boundaries.len()
    }

    /// The boundary of an index.
    pub fn boundary(&self, index: usize) -> &Boundary {
        &self.boundaries[index]
    }

    /// Whether a transition of the segment has no configuration, or the motion to it has failed.
    pub fn is_unsolved(&self, segment: RouteSegment<'_>, index: usize) -> bool {
        let ModeEdge { from, to } = segment.edge(index);
        let record = self.edges.get(from, to);
        !self.graph.transitions()[to as usize].is_found()
            || record.motion.is_none() && record.failures > 0
    }

    /// The motion of an edge with its support and stance footholds, for the chunk builder.
    pub fn mode_motion(&self, edge: ModeEdge) -> Option<ModeMotion<'_>> {
        let path = self.motion(edge)?;
        let (support, stance) = self.stance(edge);
        Some(ModeMotion { support, stance, first: self.state(edge.from).configuration, path })
    }

    /// The support mode of an edge and the footholds that carry the weight.
    fn stance(&self, edge: ModeEdge) -> (SupportMode, heapless::Vec<&Foothold, 2>) {
        let mode = self.mode(edge);
        let footholds = self.footholds(edge);
        let limbs = (0..2).filter(|&limb| mode.is_stance(limb));
        let stance = limbs
            .filter_map(|limb| footholds.iter().copied().find(|foothold| foothold.limb == limb));
        (mode.support, stance.collect())
    }

    /// The ground under each foot of an edge, by limb: where it stands, or where it lands.
    pub fn grounds(&self, edge: ModeEdge) -> [Ground; 2] {
        let at = if boundary_of(edge.to).is_some() { edge.from } else { edge.to };
        let (first, second) = self.graph.pair(at);
        left_and_right(first, second).map(|foothold| foothold.ground)
    }

    /// The two footholds of the transition of an edge, the stance first.
    fn footholds(&self, edge: ModeEdge) -> [&Foothold; 2] {
        let (stance, other) =
            self.graph.pair(if boundary_of(edge.from).is_some() { edge.to } else { edge.from });
        [stance, other]
    }

    /// Whether the mode of an edge is double support.
    pub fn is_double(&self, edge: ModeEdge) -> bool {
        let starts_double = boundary_of(edge.from)
            .is_some_and(|index| self.boundaries[index].support == SupportMode::Double);
        starts_double || boundary_of(edge.to).is_some() || edge.to == ModeGraph::twin(edge.from)
    }
}
