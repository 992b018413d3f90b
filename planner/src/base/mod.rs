//! Memory, threads, random streams and work budgets.

pub mod arena;
pub mod capacity;
pub mod random;
pub mod threads;
mod tuning;
pub(crate) mod work_budget;
