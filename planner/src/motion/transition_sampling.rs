//! Sampling one transition: attempts at a configuration from which the touched foot can also leave
//! its placement.
//!
//! A configuration that no swing can leave or reach would only be found out by the motions that
//! need it, one failed sequence after another.

use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::single_mode;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::lift_off::LiftOff;
use crate::motion::mode_graph::{ModeGraph, TransitionId};
use crate::motion::workspace::Workspace;
use crate::primitives::transition_configuration;
use crate::primitives::transition_configuration::{TransitionPair, world_from_soles};
use crate::robot::configuration::Configuration;

/// Attempts at one transition in one batch, each as often as it counts.
pub const ATTEMPTS_MAX: u32 = 24;

/// A configuration for a transition, and the same with the touched foot lifted.
#[derive(Debug, Clone, Copy)]
pub struct SampledTransition {
    /// Q(T).
    pub configuration: Configuration,
    /// The robot with its foot lifted.
    pub lifted: ModeState,
}

/// The search.
#[derive(Debug)]
pub struct TransitionSampling {
    /// What is sampled.
    pub id: TransitionId,
    mode: Mode,
    first: u32,
    attempt: u32,
    lift_off: Option<(Configuration, LiftOff)>,
    found: Option<SampledTransition>,
}

impl TransitionSampling {
    /// Goes on where earlier attempts ended.
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

    /// Whether it has found a configuration or made all its attempts.
    pub fn has_ended(&self) -> bool {
        self.found.is_some() || self.failed() >= ATTEMPTS_MAX
    }

    /// Attempts that failed.
    pub fn failed(&self) -> u32 {
        self.attempt - self.first
    }

    /// What was found; the way to the lifted state stands in the workspace.
    pub fn found(&self) -> Option<&SampledTransition> {
        self.found.as_ref()
    }

    /// Spends one unit of work.
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
            self.attempt +=
                transition_configuration::attempt_weight(&constraints.robot, self.attempt);
            workspace.count(rejection);
        }
    }

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
        let state = ModeState { configuration, world_from_soles: world_from_soles(pair) };
        self.lift_off = Some((configuration, LiftOff::new(&state)));
        Ok(())
    }
}
