//! The prior cost of a transition: an estimate of the chance that a configuration exists, from a
//! few primitive postures [Grey 4.4.2, figure 4.14].

use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, single_mode};
use crate::geometry::polygon::area_and_centroid;
use crate::motion::ids::TransitionId;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::transition::TransitionPrior;
use crate::motion::tuning::{
    ATTEMPTS_MAX, CROSSED_ATTEMPTS, PARTIAL_SUPPORT_ATTEMPTS, POSTURE_ATTEMPTS, SUPPORT_SHARE_MIN,
};
use crate::primitives::transition_configuration::first_valid_posture;
use crate::primitives::transition_pair::TransitionPair;

/// The prior of a transition. It grows with the number of primitive postures that fail on its two
/// footholds before one is valid, with crossed feet, and with partial support unless
/// `may_be_partial`.
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
    let crossed = if pair.is_crossed() { CROSSED_ATTEMPTS } else { 0 };
    let is_counted =
        |foothold: &&Foothold| !may_be_partial && has_partial_support(constraints, foothold);
    let partial = [stance, other].into_iter().filter(is_counted).count() as u32;
    TransitionPrior {
        attempts,
        extra_attempts: extra_attempts + crossed + PARTIAL_SUPPORT_ATTEMPTS * partial,
    }
}

/// Whether a foothold supports less than [`SUPPORT_SHARE_MIN`] of the sole.
fn has_partial_support(constraints: &Constraints, foothold: &Foothold) -> bool {
    let [supported, whole] =
        [&foothold.support[..], &constraints.robot.soles[foothold.limb].flat_part]
            .map(|outline| area_and_centroid(outline).0);
    supported < SUPPORT_SHARE_MIN * whole
}
