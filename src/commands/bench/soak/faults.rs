//! Counts of the faults of a soak and of their effects.

use serde::Serialize;

/// Faults that were injected.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Faults {
    /// Processes killed.
    pub(crate) kills: u64,
    /// Processes stopped for a time.
    pub(crate) stops: u64,
    /// Messages forged or repeated.
    pub(crate) messages: u64,
    /// Walks and clients interrupted.
    pub(crate) interrupts: u64,
}

/// What the faults must not cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Harm {
    /// Chunks that were never executed although the walk was accepted.
    pub(crate) lost: u64,
    /// Chunks executed twice.
    pub(crate) twice: u64,
    /// Runs without an end.
    pub(crate) hung: u64,
    /// Files left in shared memory.
    pub(crate) left_over: u64,
    /// Runs that ended otherwise than they may.
    pub(crate) wrong_ends: u64,
}
