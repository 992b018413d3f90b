//! What happened while a plan was executed.

use surefoot_shared_types::message::Check;
pub use surefoot_shared_types::message::WorldCorrection;

use crate::api::stance::Goal;

/// Why a plan is to be made anew from where the robot stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The controller refused a chunk and stands at the end of the one before.
    ChunkRefused {
        /// The refused chunk.
        sequence: u64,
        /// The check that it violates.
        check: Check,
    },
    /// The world differs from the one that was planned in.
    WorldChanged(Vec<WorldCorrection>),
    /// A foot came down elsewhere than planned; the state says where.
    FootMisplaced,
    /// Another goal was set.
    GoalChanged(Goal),
}
