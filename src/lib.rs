//! The parts of the `surefoot` command.
//!
//! Read [`commands::walk`] first: it starts a planner and a controller process, which are
//! [`commands::plan`] and [`commands::control`] of the same program, and reads their
//! [`line::RoleEvent`]s. A [`report::Report`] collects the lines, [`progress`] shows them while
//! they come, and [`verdict`] prints the summary at the end.

pub mod cli;
pub mod commands;
pub mod input;
pub mod picture;
pub mod report;
pub mod supervisor;
pub mod system;
