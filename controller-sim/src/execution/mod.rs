//! Executes chunks on a simulated robot, with disturbances and in a world that may differ.

pub mod disturbance;
pub mod executor;
pub mod ground_truth;
pub mod recent_chunks;
pub mod simulation;
pub(crate) mod tuning;
