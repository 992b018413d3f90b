//! The graph of modes and transitions [Grey 4.4.2].
//!
//! In a transition `(a | b)` foothold a carries all the weight and foothold b is touched. Its twin
//! `(b | a)` lies at the other end of the double-support mode of both. From `(a | b)` the robot
//! continues to the twin (double support), or swings its free foot to another foothold: `(a | c)`
//! (single support on a). Two footholds may have several transitions with their twins: one for each
//! configuration of Q(T).

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::Foothold;
use crate::motion::adjacency_lists::{AdjacencyLists, Swing};
use crate::motion::ids::{FootholdId, TransitionId};
use crate::motion::spatial_hash::SpatialHash;
use crate::motion::transition::{Transition, TransitionPrior};
use crate::motion::tuning::{ALTERNATIVE_ATTEMPTS, SAME_DISTANCE_MAX, SAME_HALF_SINE_MAX};
use crate::robot::configuration::Configuration;
use crate::robot::crouch::Crouch;

/// Footholds and transitions, in arenas allocated once.
#[derive(Debug)]
pub struct ModeGraph {
    footholds: Vec<Foothold>,
    spatial_hash: SpatialHash,
    adjacency: AdjacencyLists,
    first_failed: Vec<Option<TransitionId>>,
    transitions: Vec<Transition>,
    /// C(T) of each transition and its twin together, at half their index.
    step_costs: Vec<f64>,
    configurations: Vec<Configuration>,
    connected: FootholdId,
    /// The second footholds of all pairs on which a posture holds, ascending.
    seconds_of_pairs: Vec<FootholdId>,
}

impl ModeGraph {
    /// Empty arenas of these capacities, for steps of at most `reach` (m). Allocates.
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
            seconds_of_pairs: reserve(footholds_max / 2),
        }
    }

    /// The footholds.
    pub fn footholds(&self) -> &[Foothold] {
        &self.footholds
    }

    /// The transitions.
    pub fn transitions(&self) -> &[Transition] {
        &self.transitions
    }

    /// Q(T) of a transition, if a configuration was found.
    pub fn configuration(&self, id: TransitionId) -> Option<&Configuration> {
        self.transitions[id as usize]
            .configuration
            .map(|index| &self.configurations[index as usize])
    }

    /// The index of a transition's configuration in the arena, in the order of discovery.
    pub fn configuration_index(&self, id: TransitionId) -> Option<usize> {
        self.transitions[id as usize].configuration.map(|index| index as usize)
    }

    /// Records the prior of a transition.
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

    /// Records the configuration found for a transition.
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

    /// Updates the step cost of a transition and its twin.
    fn update_step_cost(&mut self, id: TransitionId) {
        let cost = |id: TransitionId| self.transitions[id as usize].cost();
        self.step_costs[id as usize / 2] = cost(id) + cost(Self::twin(id));
    }

    /// C(T) of a transition and its twin together: the cost of a step, m^3.
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

    /// Whether the motion from one transition to another may have failed. `false` is exact.
    pub fn may_have_failed(&self, from: TransitionId, to: TransitionId) -> bool {
        let transition = &self.transitions[to as usize];
        if to == Self::twin(from) {
            transition.has_failed_motion_from_twin
        } else {
            transition.has_failed_motion
        }
    }

    /// The swings from a stance foothold to which a motion has failed.
    pub fn failed_swings_from(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
        let next = |id: &TransitionId| self.transitions[*id as usize].next_failed;
        let failed_swings = std::iter::successors(self.first_failed[stance as usize], next);
        failed_swings.map(|to| Swing { to, other: self.transitions[to as usize].other })
    }

    /// Whether a motion to any transition on a stance foothold has failed.
    pub fn has_failed_motion(&self, stance: FootholdId) -> bool {
        self.first_failed[stance as usize].is_some()
    }

    /// The two footholds of a transition: the stance, the touched one.
    pub fn pair(&self, id: TransitionId) -> (&Foothold, &Foothold) {
        let transition = &self.transitions[id as usize];
        (&self.footholds[transition.stance as usize], &self.footholds[transition.other as usize])
    }

    /// The transition at the other end of the double-support mode.
    pub fn twin(id: TransitionId) -> TransitionId {
        id ^ 1
    }

    /// The swings from a stance foothold, newest first.
    pub fn swings_from(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
        self.adjacency.of_stance(stance)
    }

    /// The transitions on a stance foothold, newest first.
    pub fn of_stance(&self, stance: FootholdId) -> impl Iterator<Item = TransitionId> + '_ {
        self.swings_from(stance).map(|swing| swing.to)
    }

    /// The newest transition `(stance | other)`, if the graph contains one.
    pub fn find(&self, stance: FootholdId, other: FootholdId) -> Option<TransitionId> {
        self.find_all(stance, other).next()
    }

    /// The transitions `(stance | other)`, newest first: one for each configuration of Q(T).
    pub fn find_all(
        &self,
        stance: FootholdId,
        other: FootholdId,
    ) -> impl Iterator<Item = TransitionId> + '_ {
        self.swings_from(stance).filter(move |swing| swing.other == other).map(|swing| swing.to)
    }

    /// The foothold of the same foot with nearly the same pose, if there is one.
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

    /// The foothold with exactly this pose, if the graph contains it.
    pub fn identical(&self, limb: usize, world_from_sole: &Pose) -> Option<FootholdId> {
        self.near(limb, world_from_sole.translation)
            .find(|(_, known)| known.world_from_sole == *world_from_sole)
            .map(|(id, _)| id)
    }

    /// All footholds of a foot within a step of a position or equivalent to one there, and possibly
    /// others of that foot, in the order in which they were added.
    pub fn near(
        &self,
        limb: usize,
        position: DVec3,
    ) -> impl Iterator<Item = (FootholdId, &Foothold)> {
        let near =
            self.spatial_hash.near(limb, position).map(|id| (id, &self.footholds[id as usize]));
        near.filter(move |(_, foothold)| foothold.limb == limb)
    }

    /// Adds a foothold.
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

    /// Adds two footholds of different feet on which a posture holds.
    ///
    /// # Errors
    /// The arena is full.
    pub fn add_pair(&mut self, [first, second]: [Foothold; 2]) -> Result<(), ArenaFull> {
        self.add_foothold(first)?;
        let second = self.add_foothold(second)?;
        self.seconds_of_pairs.push(second);
        Ok(())
    }

    /// The foothold with which this one was added as the second of a pair.
    pub fn partner(&self, foothold: FootholdId) -> Option<FootholdId> {
        self.seconds_of_pairs.binary_search(&foothold).is_ok().then(|| foothold - 1)
    }

    /// Sets the crouch at a foothold.
    pub fn set_crouch(&mut self, foothold: FootholdId, crouch: Crouch) {
        self.footholds[foothold as usize].crouch = crouch;
    }

    /// The foothold with exactly this pose, added if the graph does not contain it.
    ///
    /// # Errors
    /// The arena is full.
    pub fn identical_or_new(&mut self, foothold: &Foothold) -> Result<FootholdId, ArenaFull> {
        self.identical(foothold.limb, &foothold.world_from_sole)
            .map_or_else(|| self.add_foothold(foothold.clone()), Ok)
    }

    /// Adds the two transitions between footholds of different feet.
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

    /// Adds another transition on the footholds of one, and its twin, for a further configuration
    /// of Q(T) each. Their first attempts are random: the primitive postures would give the same
    /// configurations again.
    ///
    /// # Errors
    /// The arena is full.
    pub fn add_alternative(&mut self, id: TransitionId) -> Result<(), ArenaFull> {
        let Transition { stance, other, .. } = self.transitions[id as usize];
        self.connect(stance, other)?;
        let last = self.transitions.len() as TransitionId - 1;
        for id in [Self::twin(last), last] {
            let transition = &mut self.transitions[id as usize];
            transition.attempts = ALTERNATIVE_ATTEMPTS;
            transition.extra_attempts = Some(0);
        }
        self.update_step_cost(last);
        Ok(())
    }

    /// Whether less than a quarter of the transition arena is left.
    pub fn is_nearly_full(&self) -> bool {
        4 * self.transitions.len() > 3 * self.transitions.capacity()
    }

    /// The first foothold that is not yet connected to those before it.
    pub fn connected(&self) -> FootholdId {
        self.connected
    }

    /// Records that all footholds up to this one are connected.
    pub fn mark_connected(&mut self, foothold: FootholdId) {
        self.connected = self.connected.max(foothold + 1);
    }

    /// Lets all footholds be connected with each other, those that were connected included.
    pub fn forget_connected(&mut self) {
        self.connected = 0;
    }

    /// Whether a transition has neither a prior nor a configuration.
    pub fn is_unestimated(&self, id: TransitionId) -> bool {
        let transition = &self.transitions[id as usize];
        transition.extra_attempts.is_none() && !transition.is_found()
    }

    /// Whether a transition has an unlikely prior and no configuration.
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
            + self.seconds_of_pairs.capacity() * size_of::<FootholdId>()
    }
}
