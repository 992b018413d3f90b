//! replan.

pub mod refusals;
pub mod replan_bench;
