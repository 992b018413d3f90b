//! Two planner threads against one, on cores that other threads use.

mod busy_loops;
pub mod threads_bench;
