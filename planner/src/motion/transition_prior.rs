//! The prior cost of a transition: its chance of having a configuration, from a few primitive
//! postures [Grey 4.4.2, figure 4.14].

use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, single_mode};
use crate::geometry::polygon::area_and_centroid;
use crate::motion::mode_graph::{ModeGraph, TransitionId, TransitionPrior};
use crate::motion::transition_sampling::ATTEMPTS_MAX;
use crate::primitives::transition_configuration::{
    TransitionPair, are_crossed, first_valid_posture,
};

/// Attempts that count for each primitive posture that fails before one holds.
const POSTURE_ATTEMPTS: u32 = 3;
/// Additional attempts that count for crossed feet: few swings lead there.
const CROSSED_ATTEMPTS: u32 = 3;
/// Additional attempts that count for each foothold with partial support: a robot that stands a
/// little beside it slips off [Grey 4.1.2].
const PARTIAL_SUPPORT_ATTEMPTS: u32 = 8;
/// Share of a sole's area below which its support is partial.
const SUPPORT_SHARE_MIN: f64 = 0.6;

/// The prior cost of a transition. The more primitive postures fail on its two footholds, the
/// higher it is. Partial support adds to it, unless `may_be_partial`.
pub fn transition_prior(
    constraints: &Constraints,
    id: TransitionId,
    graph: &ModeGraph,
    may_be_partial: bool,
) -> TransitionPrior {
    let (stance, other) = graph.pair(id);
    let pair = TransitionPair { stance, other };
    let (attempts, extra_attempts) =
        match first_valid_posture(constraints, &single_mode(stance), pair) {
            Some(failed) => (POSTURE_ATTEMPTS * failed as u32, 0),
            None => (ATTEMPTS_MAX, TransitionPrior::UNLIKELY),
        };
    let crossed = if are_crossed(pair) { CROSSED_ATTEMPTS } else { 0 };
    let is_counted =
        |foothold: &&Foothold| !may_be_partial && has_partial_support(constraints, foothold);
    let partial = [stance, other].into_iter().filter(is_counted).count() as u32;
    TransitionPrior {
        attempts,
        extra_attempts: extra_attempts + crossed + PARTIAL_SUPPORT_ATTEMPTS * partial,
    }
}

/// Whether a foothold supports only a small part of the sole.
fn has_partial_support(constraints: &Constraints, foothold: &Foothold) -> bool {
    let [supported, whole] =
        [&foothold.support[..], &constraints.robot.soles[foothold.limb].polygon]
            .map(|outline| area_and_centroid(outline).0);
    supported < SUPPORT_SHARE_MIN * whole
}
