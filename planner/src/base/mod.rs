//! Memory, threads, random streams, work budgets and a smooth step.

pub mod arena;
pub mod capacity;
pub mod random;
pub(crate) mod smooth_step;
pub mod threads;
mod tuning;
pub(crate) mod work_budget;
