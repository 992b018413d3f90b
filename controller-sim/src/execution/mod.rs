//! Executes chunks on a simulated robot, with disturbances and in a world that may differ.

pub(crate) mod actual_motion;
pub mod chunk_walk;
pub mod disturbance;
pub mod executed_motion;
pub mod executor;
pub mod ground_truth;
pub mod late_chunks;
pub mod late_walk;
pub mod plan_clock;
pub mod plan_ends;
pub(crate) mod plan_motion;
pub mod recent_chunks;
pub mod simulation;
pub(crate) mod tuning;
