//! A transition between two modes, and its cost [Grey 4.4.2].

use crate::motion::ids::{FootholdId, TransitionId};

/// A transition of the graph.
#[derive(Debug, Clone)]
pub struct Transition {
    /// The foothold that carries the weight.
    pub stance: FootholdId,
    /// The foothold that is touched.
    pub other: FootholdId,
    /// D(T): the distance between the two footholds, m.
    pub distance: f64,
    /// S(T): one more than the failed attempts to sample a configuration.
    pub attempts: u32,
    /// Q(T): the index of the configuration found in the arena of the graph.
    pub(crate) configuration: Option<u32>,
    /// [`TransitionPrior::extra_attempts`], once it has been estimated.
    pub(crate) extra_attempts: Option<u32>,
    /// Whether a motion to it from another transition on the same stance has failed.
    pub(crate) has_failed_motion: bool,
    /// Whether the motion to it from its twin has failed.
    pub(crate) has_failed_motion_from_twin: bool,
    pub(crate) next_failed: Option<TransitionId>,
}

impl Transition {
    /// C(T) while no single-mode search uses it, m^3 [Grey 4.4.2].
    pub fn cost(&self) -> f64 {
        if self.is_found() { 0.0 } else { self.effort() }
    }

    /// S(T) D^3(T), m^3, where S(T) includes the expected attempts of the prior.
    pub fn effort(&self) -> f64 {
        f64::from(self.attempts + self.extra_attempts.unwrap_or(0)) * self.cubed_distance()
    }

    /// D^3(T), m^3.
    pub fn cubed_distance(&self) -> f64 {
        self.distance * self.distance * self.distance
    }

    /// Whether a configuration was found.
    pub fn is_found(&self) -> bool {
        self.configuration.is_some()
    }
}

/// Initial cost of a transition, from the estimated chance that a configuration exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TransitionPrior {
    /// Attempts that S(T) starts with. Sampling skips them.
    pub attempts: u32,
    /// Attempts that the cost counts in addition.
    pub extra_attempts: u32,
}

impl TransitionPrior {
    /// Additional attempts where no primitive posture is valid: 24 attempts find one configuration
    /// in fifteen.
    pub const UNLIKELY: u32 = 120;
}
