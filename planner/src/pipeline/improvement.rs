//! What the improvement of a plan came to.

/// The improvement of a plan: other walks are made from it, and the one that takes the least time
/// is kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Improvement {
    /// Work units before it.
    pub first_work: u64,
    /// Work units of the improvement.
    pub work: u64,
    /// Duration of the first plan, s.
    pub first_seconds: f64,
    /// Duration of the best plan, s.
    pub seconds: f64,
    /// Walks that were tried.
    pub rounds: u64,
    /// Walks that took less time than the best one before.
    pub kept: u64,
}
