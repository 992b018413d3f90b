//! Short work items on several threads: the thread that searches, and helper threads.
//!
//! The search runs on the thread that calls the planner. It offers items, and helper threads claim
//! some of them. Results do not depend on who runs an item.

pub(crate) mod cores;
mod helper;
pub mod job_stack;
mod pool;
mod pool_state;
pub(crate) mod preemption;
pub mod sleep;
mod threads;
mod tuning;
pub mod word;

pub use threads::Threads;
