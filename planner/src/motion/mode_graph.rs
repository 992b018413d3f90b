//! The graph of modes and transitions [Grey 4.4.2].
//!
//! A transition `(a | b)` is "all weight on placement a, placement b touched". Its twin `(b | a)`
//! lies at the other end of the double-support mode of the two. From `(a | b)` the robot goes on to
//! the twin (double support), or swings its free foot to another placement: `(a | c)` (single
//! support on a).

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::Foothold;
use crate::motion::adjacency_lists::{AdjacencyLists, Swing};
use crate::motion::spatial_hash::SpatialHash;
use crate::robot::configuration::Configuration;
use crate::robot::crouch::Crouch;

/// Index of a foot placement.
pub type FootholdId = u32;
/// Index of a transition; the twin's is its last bit flipped.
pub type TransitionId = u32;

/// Most boundaries between segments, start and goal included.
pub const BOUNDARIES_MAX: usize = 4_096;
/// The boundary at the start.
pub const START: usize = 0;
/// The boundary at the goal.
pub const GOAL: usize = 1;

/// The node that stands for a boundary: the robot standing on both feet between two segments.
pub fn boundary_node(boundary: usize) -> TransitionId {
    TransitionId::MAX - boundary as TransitionId
}

/// The boundary that a node stands for, if it is none of the transitions.
pub fn boundary_of(node: TransitionId) -> Option<usize> {
    let index = (TransitionId::MAX - node) as usize;
    (index < BOUNDARIES_MAX).then_some(index)
}

/// A transition of the graph.
#[derive(Debug, Clone)]
pub struct Transition {
    /// The placement that carries the robot.
    pub stance: FootholdId,
    /// The placement that is touched.
    pub other: FootholdId,
    /// D(T): the distance between the two placements, m.
    pub distance: f64,
    /// S(T): one more than the failed attempts to sample it.
    pub attempts: u32,
    /// Q(T): the configuration that was found, as its place in the graph's arena.
    configuration: Option<u32>,
    /// [`TransitionPrior::extra_attempts`], once it has been estimated.
    extra_attempts: Option<u32>,
    /// Whether a motion to it from another transition on the same stance has failed.
    has_failed_motion: bool,
    /// Whether the motion to it from its twin has failed.
    has_failed_motion_from_twin: bool,
    next_failed: Option<TransitionId>,
}

impl Transition {
    /// C(T) of a transition that no single-mode search uses [Grey 4.4.2].
    pub fn cost(&self) -> f64 {
        if self.is_found() { 0.0 } else { self.effort() }
    }

    /// S(T) D^3(T), m^3, where S(T) also counts the attempts that it is expected to take.
    pub fn effort(&self) -> f64 {
        f64::from(self.attempts + self.extra_attempts.unwrap_or(0)) * self.cubed_distance()
    }

    /// D^3(T), m^3.
    pub fn cubed_distance(&self) -> f64 {
        self.distance * self.distance * self.distance
    }

    /// Whether Q(T) holds a configuration.
    pub fn is_found(&self) -> bool {
        self.configuration.is_some()
    }
}

/// What a transition begins with before it is sampled, by how likely it looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TransitionPrior {
    /// Failed attempts that S(T) begins with: sampling goes on after them.
    pub attempts: u32,
    /// Attempts that its cost counts in addition.
    pub extra_attempts: u32,
}

impl TransitionPrior {
    /// Attempts that a transition is expected to take in addition where no primitive posture holds
    /// on it: 24 of them find one in fifteen.
    pub const UNLIKELY: u32 = 120;
}

/// The arenas of the graph, allocated once.
#[derive(Debug)]
pub struct ModeGraph {
    footholds: Vec<Foothold>,
    spatial_hash: SpatialHash,
    adjacency: AdjacencyLists,
    first_failed: Vec<Option<TransitionId>>,
    transitions: Vec<Transition>,
    /// C(T) of each transition and its twin together, by half their index.
    step_costs: Vec<f64>,
    configurations: Vec<Configuration>,
    connected: FootholdId,
}

/// Two placements of one foot closer than this are one, m.
const SAME_DISTANCE_MAX: f64 = 0.01;
/// Two placements of one foot turned less than this against each other are one, as the sine of half
/// the angle.
const SAME_HALF_SINE_MAX: f64 = 0.02;

impl ModeGraph {
    /// Empty arenas of these capacities, for steps of at most `reach` (m).
    pub fn new(
        footholds_max: usize,
        transitions_max: usize,
        configurations_max: usize,
        reach: f64,
    ) -> Self {
        Self {
            footholds: reserve(footholds_max),
            spatial_hash: SpatialHash::new(reach.max(SAME_DISTANCE_MAX), footholds_max),
            adjacency: AdjacencyLists::new(footholds_max, transitions_max),
            first_failed: reserve(footholds_max),
            transitions: reserve(transitions_max),
            step_costs: reserve(transitions_max / 2),
            configurations: reserve(configurations_max),
            connected: 0,
        }
    }

    /// The placements.
    pub fn footholds(&self) -> &[Foothold] {
        &self.footholds
    }

    /// The transitions.
    pub fn transitions(&self) -> &[Transition] {
        &self.transitions
    }

    /// The configuration of a transition, if one was found.
    pub fn configuration(&self, id: TransitionId) -> Option<&Configuration> {
        self.transitions[id as usize]
            .configuration
            .map(|index| &self.configurations[index as usize])
    }

    /// The place of a transition's configuration in the arena: how many were found before.
    pub fn configuration_index(&self, id: TransitionId) -> Option<usize> {
        self.transitions[id as usize].configuration.map(|index| index as usize)
    }

    /// Records how likely a transition looks.
    pub fn record_prior(&mut self, id: TransitionId, prior: TransitionPrior) {
        let transition = &mut self.transitions[id as usize];
        transition.attempts += prior.attempts;
        transition.extra_attempts = Some(prior.extra_attempts);
        self.update_step_cost(id);
    }

    /// Records failed attempts to sample a transition.
    pub fn record_failures(&mut self, id: TransitionId, failed: u32) {
        self.transitions[id as usize].attempts += failed;
        self.update_step_cost(id);
    }

    /// Records the configuration that was found for a transition.
    ///
    /// # Errors
    /// The arena of configurations is full.
    pub fn record_found(
        &mut self,
        id: TransitionId,
        found: Configuration,
    ) -> Result<(), ArenaFull> {
        if self.configurations.len() == self.configurations.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.transitions[id as usize].configuration = Some(self.configurations.len() as u32);
        self.configurations.push(found);
        self.update_step_cost(id);
        Ok(())
    }

    fn update_step_cost(&mut self, id: TransitionId) {
        let cost = |id: TransitionId| self.transitions[id as usize].cost();
        self.step_costs[id as usize / 2] = cost(id) + cost(Self::twin(id));
    }

    /// C(T) of a transition and its twin together: what it costs to swing a foot there and to set
    /// it down, m^3.
    pub fn step_cost(&self, id: TransitionId) -> f64 {
        self.step_costs[id as usize / 2]
    }

    /// Records that the motion from one transition to another has failed.
    pub fn record_failed_motion(&mut self, from: TransitionId, to: TransitionId) {
        let transition = &mut self.transitions[to as usize];
        if to == Self::twin(from) {
            transition.has_failed_motion_from_twin = true;
        } else if !transition.has_failed_motion {
            transition.has_failed_motion = true;
            transition.next_failed = self.first_failed[transition.stance as usize].replace(to);
        }
    }

    /// Whether the motion from one transition to another may have failed; it has not where the
    /// answer is no.
    pub fn may_have_failed(&self, from: TransitionId, to: TransitionId) -> bool {
        let transition = &self.transitions[to as usize];
        if to == Self::twin(from) {
            transition.has_failed_motion_from_twin
        } else {
            transition.has_failed_motion
        }
    }

    /// The swings from a stance to which a motion has failed.
    pub fn failed_swings_from(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
        let next = |id: &TransitionId| self.transitions[*id as usize].next_failed;
        let failed_swings = std::iter::successors(self.first_failed[stance as usize], next);
        failed_swings.map(|to| Swing { to, other: self.transitions[to as usize].other })
    }

    /// Whether a motion has failed to any transition on a stance.
    pub fn has_failed_motion(&self, stance: FootholdId) -> bool {
        self.first_failed[stance as usize].is_some()
    }

    /// A transition's two placements: stance, other.
    pub fn pair(&self, id: TransitionId) -> (&Foothold, &Foothold) {
        let transition = &self.transitions[id as usize];
        (&self.footholds[transition.stance as usize], &self.footholds[transition.other as usize])
    }

    /// The transition at the other end of the double-support mode.
    pub fn twin(id: TransitionId) -> TransitionId {
        id ^ 1
    }

    /// The swings from a placement, newest first.
    pub fn swings_from(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
        self.adjacency.from_stance(stance)
    }

    /// The transitions whose stance is a placement, newest first.
    pub fn from_stance(&self, stance: FootholdId) -> impl Iterator<Item = TransitionId> + '_ {
        self.swings_from(stance).map(|swing| swing.to)
    }

    /// The transition `(stance | other)`, if the graph has it.
    pub fn find(&self, stance: FootholdId, other: FootholdId) -> Option<TransitionId> {
        self.swings_from(stance).find(|swing| swing.other == other).map(|swing| swing.to)
    }

    /// The placement of the same foot that is all but this one, if there is one.
    pub fn find_equivalent(&self, foothold: &Foothold) -> Option<FootholdId> {
        let is_same = |known: &Foothold| {
            let turn =
                known.world_from_sole.rotation.conjugate() * foothold.world_from_sole.rotation;
            known.distance(foothold) < SAME_DISTANCE_MAX && turn.xyz().length() < SAME_HALF_SINE_MAX
        };
        self.near(foothold.limb, foothold.world_from_sole.translation)
            .find(|&(_, known)| is_same(known))
            .map(|(id, _)| id)
    }

    /// The very same placement, if the graph has it.
    pub fn identical(&self, limb: usize, world_from_sole: &Pose) -> Option<FootholdId> {
        self.near(limb, world_from_sole.translation)
            .find(|(_, known)| known.world_from_sole == *world_from_sole)
            .map(|(id, _)| id)
    }

    /// All placements of a foot that a step leads to from a place, or that are the same as one
    /// there, and perhaps others of that foot, in their order.
    pub fn near(
        &self,
        limb: usize,
        position: DVec3,
    ) -> impl Iterator<Item = (FootholdId, &Foothold)> {
        let near =
            self.spatial_hash.near(limb, position).map(|id| (id, &self.footholds[id as usize]));
        near.filter(move |(_, foothold)| foothold.limb == limb)
    }

    /// Adds a placement.
    ///
    /// # Errors
    /// The arena is full.
    pub fn add_foothold(&mut self, foothold: Foothold) -> Result<FootholdId, ArenaFull> {
        if self.footholds.len() == self.footholds.capacity() {
            return Err(ArenaFull::Footholds);
        }
        self.spatial_hash.add(foothold.limb, foothold.world_from_sole.translation);
        self.footholds.push(foothold);
        self.adjacency.add_stance();
        self.first_failed.push(None);
        Ok((self.footholds.len() - 1) as FootholdId)
    }

    /// Sets the crouch at a placement.
    pub fn set_crouch(&mut self, foothold: FootholdId, crouch: Crouch) {
        self.footholds[foothold as usize].crouch = crouch;
    }

    /// The very same placement, added if the graph does not have it.
    ///
    /// # Errors
    /// The arena is full.
    pub fn identical_or_new(&mut self, foothold: &Foothold) -> Result<FootholdId, ArenaFull> {
        self.identical(foothold.limb, &foothold.world_from_sole)
            .map_or_else(|| self.add_foothold(foothold.clone()), Ok)
    }

    /// Adds the two transitions between placements of different feet.
    ///
    /// # Errors
    /// The arena is full.
    pub fn connect(&mut self, a: FootholdId, b: FootholdId) -> Result<(), ArenaFull> {
        if self.transitions.len() + 2 > self.transitions.capacity() {
            return Err(ArenaFull::Transitions);
        }
        let distance = self.footholds[a as usize].distance(&self.footholds[b as usize]);
        for (stance, other) in [(a, b), (b, a)] {
            let id = self.transitions.len() as TransitionId;
            self.adjacency.add(stance, Swing { to: id, other });
            self.transitions.push(Transition {
                stance,
                other,
                distance,
                attempts: 1,
                configuration: None,
                extra_attempts: None,
                has_failed_motion: false,
                has_failed_motion_from_twin: false,
                next_failed: None,
            });
        }
        self.step_costs.push(0.0);
        self.update_step_cost(self.transitions.len() as TransitionId - 1);
        Ok(())
    }

    /// The first placement that was not yet connected to those before it.
    pub fn connected(&self) -> FootholdId {
        self.connected
    }

    /// Records that all placements up to this one are connected.
    pub fn mark_connected(&mut self, foothold: FootholdId) {
        self.connected = self.connected.max(foothold + 1);
    }

    /// Whether it has not been said yet how likely a transition without a configuration is.
    pub fn is_unestimated(&self, id: TransitionId) -> bool {
        let transition = &self.transitions[id as usize];
        transition.extra_attempts.is_none() && !transition.is_found()
    }

    /// Whether a transition without a configuration has been estimated to be unlikely.
    pub fn is_unlikely(&self, id: TransitionId) -> bool {
        let transition = &self.transitions[id as usize];
        transition.extra_attempts >= Some(TransitionPrior::UNLIKELY) && !transition.is_found()
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.footholds.capacity() * (size_of::<Foothold>() + size_of::<Option<TransitionId>>())
            + self.spatial_hash.bytes()
            + self.adjacency.bytes()
            + self.step_costs.capacity() * size_of::<f64>()
            + self.transitions.capacity() * size_of::<Transition>()
            + self.configurations.capacity() * size_of::<Configuration>()
    }
}
