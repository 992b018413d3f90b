//! Transition sampling: attempts at a configuration of one transition from which the touched foot
//! can also lift off [Grey 4.4.2].
//!
//! Without the lift-off test, configurations that no swing can leave or reach would be detected
//! only by motions that fail, one sequence after another.

use crate::base::random::{Random, Stream};
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::single_mode;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::ids::TransitionId;
use crate::motion::lift_off::LiftOff;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::tuning::ATTEMPTS_MAX;
use crate::motion::workspace::Workspace;
use crate::primitives::transition_configuration;
use crate::primitives::transition_pair::TransitionPair;
use crate::robot::configuration::Configuration;

/// A configuration of a transition, and the state with the touched foot lifted.
#[derive(Debug, Clone, Copy)]
pub struct SampledTransition {
    /// Q(T).
    pub configuration: Configuration,
    /// The state with the foot lifted.
    pub lifted: ModeState,
}

/// The sampling of one transition.
#[derive(Debug)]
pub struct TransitionSampling {
    /// The transition that is sampled.
    pub id: TransitionId,
    mode: Mode,
    /// The first attempt; earlier ones were made by earlier batches.
    first: u32,
    attempt: u32,
    lift_off: Option<(Configuration, LiftOff)>,
    found: Option<SampledTransition>,
}

impl TransitionSampling {
    /// Sampling that continues after the attempts made so far.
    pub fn new(graph: &ModeGraph, id: TransitionId) -> Self {
        let first = graph.transitions()[id as usize].attempts - 1;
        Self {
            id,
            mode: single_mode(graph.pair(id).0),
            first,
            attempt: first,
            lift_off: None,
            found: None,
        }
    }

    /// Whether a configuration was found or all attempts of this batch were made.
    pub fn has_ended(&self) -> bool {
        self.found.is_some() || self.failed() >= ATTEMPTS_MAX
    }

    /// Weight of the attempts that failed.
    pub fn failed(&self) -> u32 {
        self.attempt - self.first
    }

    /// The configuration found, if any. The workspace holds the path to the lifted state.
    pub fn found(&self) -> Option<&SampledTransition> {
        self.found.as_ref()
    }

    /// Spends one work unit.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        seed: u64,
        graph: &ModeGraph,
        workspace: &mut Workspace,
    ) {
        let advanced = match &mut self.lift_off {
            None => self.sample_configuration(constraints, seed, graph),
            Some((configuration, lift_off)) => lift_off
                .advance(
                    constraints,
                    &self.mode,
                    &mut workspace.local_planner,
                    &mut workspace.lift_offs[0],
                )
                .map(|lifted| {
                    self.found = lifted
                        .map(|lifted| SampledTransition { configuration: *configuration, lifted })
                }),
        };
        if let Err(rejection) = advanced {
            self.lift_off = None;
            let (stance, other) = graph.pair(self.id);
            self.attempt += transition_configuration::attempt_weight(
                &constraints.robot,
                TransitionPair { stance, other },
                self.attempt,
            );
            workspace.count(rejection);
        }
    }

    /// Makes the next attempt at a configuration, and begins its lift-off if it is valid.
    fn sample_configuration(
        &mut self,
        constraints: &Constraints,
        seed: u64,
        graph: &ModeGraph,
    ) -> Result<(), Rejection> {
        let (stance, other) = graph.pair(self.id);
        let pair = TransitionPair { stance, other };
        let name = (seed, u64::from(self.id));
        let configuration = transition_configuration::sample(
            constraints,
            &self.mode,
            pair,
            name,
            u64::from(self.attempt),
        )?;
        let state = ModeState { configuration, world_from_soles: pair.world_from_soles() };
        let attempt = u64::from(self.attempt);
        let lift_off = if transition_configuration::is_unbounded(attempt) {
            let mut random =
                Random::new(seed, Stream::Transition, u64::from(self.id) | 1 << 40, attempt);
            let sole = self.mode.swing().map(|limb| &constraints.robot.soles[limb]);
            LiftOff::aside(&state, &mut random, sole.map_or(&[], |sole| &sole.polygon))
        } else {
            LiftOff::new(&state)
        };
        self.lift_off = Some((configuration, lift_off));
        Ok(())
    }
}
