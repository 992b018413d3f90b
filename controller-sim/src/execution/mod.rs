//! execution.

pub mod disturbance;
pub mod executor;
pub mod ground_truth;
pub mod simulation;
