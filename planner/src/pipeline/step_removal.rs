//! Removal of needless steps: once a segment is complete, the cheapest sequence is searched again
//! over the placements that it uses, for fewer and moderate steps [Grey 4.4.6]. If no shorter
//! sequence can be completed, the segment keeps its current one.

use crate::base::capacity::ArenaFull;
use crate::motion::ids::TransitionId;
use crate::motion::transition_sequence::Objective;
use crate::pipeline::search::Search;
use crate::pipeline::segment_searches::{SegmentSearch, SegmentState};
use crate::preparation::planning_context::PlanningContext;

/// The current segment's sequence has all its motions: it is kept as the best, and a shorter one
/// is searched.
///
/// # Errors
/// The sequence does not fit.
pub(crate) fn remove_steps_of_complete(
    context: &PlanningContext,
    search: &mut Search,
) -> Result<(), ArenaFull> {
    let SegmentSearch { sequence, best, .. } = search.segments.current_mut();
    best.clear();
    best.extend_from_slice(sequence);
    remove_steps(context, search)
}

/// Searches the cheapest sequence over the placements of the best, if attempts are left; else
/// completes the segment.
///
/// # Errors
/// The sequence does not fit.
pub(crate) fn remove_steps(
    context: &PlanningContext,
    search: &mut Search,
) -> Result<(), ArenaFull> {
    let current = search.segments.current_mut();
    if current.step_removals < context.constraints.config.step_removal_rounds_max {
        current.seek(Objective::FewerSteps);
        return Ok(());
    }
    keep_best(search)
}

/// Takes the sequence that was found, if one was and it is shorter than the best; else completes
/// the segment.
///
/// # Errors
/// The sequence does not fit.
pub(crate) fn take_shorter(
    search: &mut Search,
    found: Option<&[TransitionId]>,
) -> Result<(), ArenaFull> {
    let current = search.segments.current_mut();
    match found.filter(|found| found.len() < current.best.len()) {
        None => keep_best(search),
        Some(found) => {
            current.step_removals += 1;
            current.take(found, SegmentState::Sample { next: 0, failed: false })
        }
    }
}

fn keep_best(search: &mut Search) -> Result<(), ArenaFull> {
    let SegmentSearch { sequence, best, step_removals, .. } = search.segments.current_mut();
    *step_removals = 0;
    std::mem::swap(sequence, best);
    search.complete_segment()
}
