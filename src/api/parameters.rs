//! The parameters of planning, checking and moving.

pub use surefoot_shared_types::config::{
    CheckerConfig, ExecutionConfig, MotionKind, PlannerConfig,
};

/// Everything that bounds or shapes a search and its motion, and the checker's tolerances.
/// `docs/PARAMETERS.md` lists them with unit, range and source.
/// [`PlannerBuilder::build`](crate::PlannerBuilder::build) validates them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parameters {
    /// The planner's budget and margins, as in a scenario's `[planner]`.
    pub planner: PlannerConfig,
    /// The checker's tolerances, as in a scenario's `[checker]`.
    pub checker: CheckerConfig,
    /// How the plan moves, as in a scenario's `[execution]`.
    pub execution: ExecutionConfig,
}
