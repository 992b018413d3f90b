//! Sampling one transition: attempts at a configuration from which the touched foot can also leave
//! its placement.
//!
//! A configuration that no swing can leave or reach would only be found out by the motions that
//! need it, one failed sequence after another.

use crate::body::Configuration;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::foothold::single_mode;
use crate::motion::graph::{Graph, TransitionId};
use crate::motion::lift::Lift;
use crate::motion::track::State;
use crate::motion::transition::{self, TransitionPair, world_from_soles};
use crate::motion::workspace::Workspace;

/// Attempts at one transition in one round, each as often as it counts.
pub const ATTEMPTS_MAX: u32 = 24;

/// A configuration for a transition, and the same with the touched foot lifted.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Q(T).
    pub configuration: Configuration,
    /// The robot with its foot lifted.
    pub lifted: State,
}

/// The search.
#[derive(Debug)]
pub struct Sampling {
    /// What is sampled.
    pub id: TransitionId,
    mode: Mode,
    first: u32,
    attempt: u32,
    lift: Option<(Configuration, Lift)>,
    found: Option<Found>,
}

impl Sampling {
    /// Goes on where earlier attempts ended.
    pub fn new(graph: &Graph, id: TransitionId) -> Self {
        let first = graph.transitions()[id as usize].attempts - 1;
        Self {
            id,
            mode: single_mode(graph.pair(id).0),
            first,
            attempt: first,
            lift: None,
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
    pub fn found(&self) -> Option<&Found> {
        self.found.as_ref()
    }

    /// Spends one unit of work.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        seed: u64,
        graph: &Graph,
        workspace: &mut Workspace,
    ) {
        let advanced = match &mut self.lift {
            None => self.draw(constraints, seed, graph),
            Some((configuration, lift)) => lift
                .advance(constraints, &self.mode, &mut workspace.follower, &mut workspace.lifts[0])
                .map(|lifted| {
                    self.found =
                        lifted.map(|lifted| Found { configuration: *configuration, lifted })
                }),
        };
        if let Err(rejection) = advanced {
            self.lift = None;
            self.attempt += transition::counts(&constraints.body, self.attempt);
            workspace.count(rejection);
        }
    }

    fn draw(
        &mut self,
        constraints: &Constraints,
        seed: u64,
        graph: &Graph,
    ) -> Result<(), Rejection> {
        let (stance, other) = graph.pair(self.id);
        let pair = TransitionPair { stance, other };
        let name = (seed, u64::from(self.id));
        let configuration =
            transition::sample(constraints, &self.mode, pair, name, u64::from(self.attempt))?;
        let state = State { configuration, world_from_soles: world_from_soles(pair) };
        self.lift = Some((configuration, Lift::new(&state)));
        Ok(())
    }
}
