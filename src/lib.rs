//! The parts of the `surefoot` command.
//!
//! Read [`commands::walk`] first: it starts a planner and a controller process, which are
//! [`commands::plan`] and [`commands::control`] of the same program, and reads their
//! [`line::RoleEvent`]s. A [`report::Report`] collects the lines, [`progress`] shows them while
//! they come, and [`verdict`] prints the summary at the end.

pub mod affinity;
pub mod allocations;
pub mod arguments;
pub mod audience;
pub mod clock;
pub mod commands;
pub mod failure;
pub mod inputs;
pub mod line;
pub mod margins;
pub mod memory;
pub mod outputs;
pub mod picture;
pub mod preparation;
pub mod progress;
pub mod report;
pub mod search;
pub mod signals;
pub mod supervisor;
pub mod terminal;
pub mod terrain;
pub mod verdict;
