//! supervisor.

pub mod process;
pub mod supervisor;
