//! Placements read off the geometry, and random perturbations of them.

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::foot_placement::candidates::next_candidate;
use crate::foot_placement::plane_features::Candidate;
use crate::foot_placement::proposal::{Examined, Proposal};
use crate::foot_placement::request::Source;
use crate::foot_placement::sole_support::NoSupport;
use crate::foot_placement::tuning::{
    PERTURBATION_SHIFT, PERTURBATION_TURN, PERTURBED_CANDIDATES_MAX, REPEATED_DISTANCE,
};

/// The geometric candidates: first those with a large support, then those with enough.
pub(crate) fn propose_geometric(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    proposal.scratch.candidates.deferred.clear();
    let [requirement, relaxed] = [1.0, 0.0].map(|share| proposal.requirement(share));
    let mut count = 0;
    while count < proposal.query.limits.geometric_max
        && next_candidate(proposal.surfaces, proposal.scratch, proposal.query)
    {
        let last = proposal.scratch.candidates.best.len() - 1;
        if is_repeated(&proposal.scratch.candidates.best, last) {
            continue;
        }
        count += 1;
        let pose = proposal.scratch.candidates.best[last].world_from_sole;
        let examined = proposal.examine(pose, Source::Geometric, requirement)?;
        if examined == Examined::Rejected(NoSupport::AreaTooSmall)
            && requirement.area_min > relaxed.area_min
            && proposal.scratch.contacts.area_max >= relaxed.area_min
        {
            proposal.scratch.candidates.deferred.push(last as u32);
        }
    }
    for i in 0..proposal.scratch.candidates.deferred.len() {
        let index = proposal.scratch.candidates.deferred[i] as usize;
        let pose = proposal.scratch.candidates.best[index].world_from_sole;
        proposal.examine(pose, Source::Geometric, relaxed)?;
    }
    ControlFlow::Continue(())
}

/// Whether a candidate repeats one just before it. Costs are sorted, so a repetition is near in the
/// list.
fn is_repeated(candidates: &[Candidate], index: usize) -> bool {
    let at = &candidates[index];
    let is_same = |pose: &Pose| {
        let turn = (pose.rotation.conjugate() * at.world_from_sole.rotation).xyz().length();
        (pose.translation - at.world_from_sole.translation).length() < REPEATED_DISTANCE
            && turn < REPEATED_DISTANCE
    };
    let before = candidates[..index].iter().rev();
    before
        .take_while(|c| at.cost - c.cost < 2.0 * REPEATED_DISTANCE)
        .any(|c| is_same(&c.world_from_sole))
}

/// Random perturbations of the nearest candidates, in turn.
pub(crate) fn propose_perturbed(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    let count = proposal.scratch.candidates.best.len().min(PERTURBED_CANDIDATES_MAX);
    for i in 0..proposal.query.limits.perturbed_max as usize {
        if count == 0 {
            break;
        }
        let base = proposal.scratch.candidates.best[i % count].world_from_sole;
        let shift = DVec3::new(
            proposal.random.uniform(-PERTURBATION_SHIFT, PERTURBATION_SHIFT),
            proposal.random.uniform(-PERTURBATION_SHIFT, PERTURBATION_SHIFT),
            0.0,
        );
        let turn = proposal.random.uniform(-PERTURBATION_TURN, PERTURBATION_TURN);
        let pose = base * Pose::from_parts(shift, rotation_about(DVec3::Z, turn));
        if proposal.query.is_in_reach(&pose) {
            proposal.examine(pose, Source::Perturbed, proposal.requirement(0.0))?;
        }
    }
    ControlFlow::Continue(())
}
