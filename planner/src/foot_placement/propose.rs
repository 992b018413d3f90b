//! Placements near an ideal one, by source: rough ground, geometry, perturbations, Algorithm 1.

use std::ops::ControlFlow;

use crate::foot_placement::algorithm_1::propose_sampled;
use crate::foot_placement::candidates::begin_candidates;
use crate::foot_placement::features::gather;
use crate::foot_placement::geometric::{propose_geometric, propose_perturbed};
use crate::foot_placement::proposal::Proposal;
use crate::foot_placement::request::{PlacementQuery, PlacementStats, Source, SupportedSole};
use crate::foot_placement::rough_ground::{is_rough, propose_on_rough_ground};
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::surfaces::Surfaces;

/// Passes placements within reach to `out`, best first, until it returns `false` or the limits are
/// reached. The order depends on nothing but the arguments. An ideal that is not finite finds
/// nothing. Placements that only a second face holds come from
/// [`propose_nests`](crate::foot_placement::propose_nests).
pub fn propose(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    query: &PlacementQuery,
    out: &mut dyn FnMut(SupportedSole) -> bool,
) -> PlacementStats {
    let mut proposal = Proposal::new(surfaces, scratch, query, out);
    if query.is_finite() {
        proposal.stats.stopped = propose_all(&mut proposal).is_break();
    }
    proposal.stats
}

fn propose_all(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    gather(proposal.surfaces, proposal.scratch, proposal.query);
    proposal.stats.features = proposal.scratch.features.len() as u32;
    if !has_bearing_ground(proposal) {
        return ControlFlow::Continue(());
    }
    let is_rough = is_rough(proposal);
    if is_rough {
        propose_on_rough_ground(proposal)?;
    }
    begin_candidates(proposal.surfaces, proposal.scratch, proposal.query);
    propose_geometric(proposal)?;
    if !is_rough && proposal.stats.found == [0; Source::COUNT] {
        propose_on_rough_ground(proposal)?;
    }
    propose_perturbed(proposal)?;
    propose_sampled(proposal)
}

/// Whether some ground within reach may bear a sole. Of too many features some are not known.
fn has_bearing_ground(proposal: &Proposal<'_, '_>) -> bool {
    let (surfaces, features) = (proposal.surfaces, &proposal.scratch.features);
    features.len() >= surfaces.config().features_max
        || features.iter().any(|&(_, id)| surfaces.may_bear(id))
}
