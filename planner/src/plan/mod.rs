//! A motion as plan chunks: division, times, digests, and the planner's own check of a plan.

pub(crate) mod chunk_builder;
pub(crate) mod joint_acceleration;
pub mod self_check;
pub(crate) mod time_parameterization;
mod tuning;
