//! The cycle of stage M [Grey 4.4, figure 4.13] for all segments in parallel: configurations for
//! the transitions of a sequence, then motions within its modes.
//!
//! ```text
//! Seek(Find) -> Sample -> Move -> complete
//!    ^            |         |
//!    |<- failed --'         v
//!    |             Seek(Join) -> Move -> complete
//!    |                             |
//!    '<--------- failed -----------'
//! ```
//!
//! The modes of a sequence that [`Objective::Feasible`] gave are searched first. Where one of its
//! motions is missing, [`Objective::ConnectModes`] chooses the modes to search next among all
//! transitions that have a configuration, by the work already spent in the modes [Grey 4.4.3]. The
//! trees in these modes are kept and grow further.

use crate::base::capacity::ArenaFull;
use crate::motion::transition_sequence::Objective;
use crate::motion::tuning::SEGMENT_SEARCHES_MAX;
use crate::pipeline::search::Search;
use crate::pipeline::segment_searches::{SegmentSearch, SegmentState};
use crate::pipeline::stage::Event;
use crate::pipeline::step_removal::{remove_steps, remove_steps_of_complete};
use crate::preparation::planning_context::PlanningContext;

/// Samples configurations Q(T) for the transitions of all sequences that need some [Grey 4.4.2].
/// Has no state: [`Search`] has the batch and the segments.
#[derive(Debug, Default)]
pub(crate) struct ConfigurationStage;

impl ConfigurationStage {
    /// Begins a batch, or advances it by at most `budget` units of work; merges it at its end.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if !search.batch.is_running() {
            begin_sampling(search);
        }
        let Some(batch) = search.advance_batch(context, budget)? else {
            return Ok(Event::Continue);
        };
        search.stats.transitions_found += u64::from(batch.found);
        for index in 0..SEGMENT_SEARCHES_MAX {
            search.segments.select(index);
            after_sampling(context, search, batch.failures[index] > 0)?;
        }
        Ok(Event::Done)
    }
}

/// Begins a batch of configurations for all segments that sample.
fn begin_sampling(search: &mut Search) {
    let Search { batch, segments, segmentation, roadmap, .. } = search;
    batch.begin();
    for (index, segment) in segments.active() {
        if let SegmentState::Sample { next, failed } = segment.state {
            let sequence = segmentation.segment(segment.segment, &segment.sequence);
            let next = batch.add_sampling(index, roadmap, sequence, next);
            segment.state = SegmentState::Sample { next, failed };
        }
    }
}

/// The next task of the current segment after a batch in which one of its searches may have failed.
fn after_sampling(
    context: &PlanningContext,
    search: &mut Search,
    has_failed: bool,
) -> Result<(), ArenaFull> {
    let current = search.segments.current_mut();
    let SegmentSearch { state: SegmentState::Sample { next, failed }, ref sequence, .. } = *current
    else {
        return Ok(());
    };
    let failed = failed || has_failed;
    current.state = match current.objective {
        _ if next < sequence.len() => SegmentState::Sample { next, failed },
        _ if !failed => SegmentState::Move { next: 0, failed: false },
        Objective::FewerSteps => return remove_steps(context, search),
        Objective::Feasible | Objective::FromGoal | Objective::ConnectModes => SegmentState::Failed,
    };
    Ok(())
}

/// Plans motions within single modes along all sequences whose transitions have configurations
/// [Grey 4.4.3]. Has no state: [`Search`] has the batch and the segments.
#[derive(Debug, Default)]
pub(crate) struct MotionStage;

impl MotionStage {
    /// Begins a batch, or advances it by at most `budget` units of work; merges it at its end.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if !search.batch.is_running() {
            begin_motions(context, search);
        }
        let Some(batch) = search.advance_batch(context, budget)? else {
            return Ok(Event::Continue);
        };
        search.stats.motions_found += u64::from(batch.found);
        for index in 0..SEGMENT_SEARCHES_MAX {
            search.segments.select(index);
            after_motions(context, search, batch.failures[index] > 0)?;
        }
        Ok(Event::Done)
    }
}

/// Begins a batch of motions for all segments that plan some.
fn begin_motions(context: &PlanningContext, search: &mut Search) {
    let Search { batch, segments, segmentation, roadmap, .. } = search;
    batch.begin();
    for (index, segment) in segments.active() {
        if let SegmentState::Move { next, failed } = segment.state {
            let sequence = segmentation.segment(segment.segment, &segment.sequence);
            let next = batch.add_motions(index, context, roadmap, sequence, next);
            segment.state = SegmentState::Move { next, failed };
        }
    }
}

/// The next task of the current segment after a batch in which one of its searches may have failed.
fn after_motions(
    context: &PlanningContext,
    search: &mut Search,
    has_failed: bool,
) -> Result<(), ArenaFull> {
    let is_direct = search.direct.is_active;
    let current = search.segments.current_mut();
    let SegmentSearch { state: SegmentState::Move { next, failed }, ref sequence, .. } = *current
    else {
        return Ok(());
    };
    let failed = failed || has_failed;
    match current.objective {
        _ if next <= sequence.len() => current.state = SegmentState::Move { next, failed },
        _ if !failed => return remove_steps_of_complete(context, search),
        Objective::Feasible if is_direct => current.state = SegmentState::Failed,
        Objective::Feasible => current.seek(Objective::ConnectModes),
        Objective::FromGoal | Objective::ConnectModes => current.state = SegmentState::Failed,
        Objective::FewerSteps => return remove_steps(context, search),
    }
    Ok(())
}
