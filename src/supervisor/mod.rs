//! The process that starts the planner and the controller, reads their events and ends them.

pub mod process;
pub mod role_processes;
pub mod silence;
pub mod supervisor;
pub mod walk_state;
