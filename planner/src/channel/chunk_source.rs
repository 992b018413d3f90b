//! Where the sender takes the chunks of a plan from: all at once, or while they are made.

use surefoot_shared_types::message::PlanChunk;

/// Whether more chunks are to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SourceState {
    /// More follow.
    Open,
    /// The last chunk ends the plan.
    Complete,
    /// No more follow, and none ends the plan.
    Ended,
}

/// The chunks of one plan. Those made do not change.
pub trait ChunkSource {
    /// The chunks made so far, in order.
    fn chunks(&self) -> &[PlanChunk];

    /// Whether more are to follow.
    fn state(&self) -> SourceState;

    /// Goes on making chunks for a few milliseconds; called as long as more are to follow.
    fn advance(&mut self);
}

/// The chunks of a complete plan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompletePlan<'a>(pub &'a [PlanChunk]);

impl ChunkSource for CompletePlan<'_> {
    fn chunks(&self) -> &[PlanChunk] {
        self.0
    }

    fn state(&self) -> SourceState {
        SourceState::Complete
    }

    fn advance(&mut self) {}
}
