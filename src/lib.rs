//! The parts of the `surefoot` command.
//!
//! [`commands::walk`] starts a planner and a controller process, which run [`commands::plan`] and
//! [`commands::control`] of the same program. [`supervisor`] reads their
//! [`report::event::RoleEvent`]s, [`report::run_report::Report`] collects them,
//! [`report::progress`] shows them, and [`report::summary`] prints the result.
//!
//! All folders except [`system`] belong to the command and need the default feature `cli`.

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod commands;
#[cfg(feature = "cli")]
pub mod input;
#[cfg(feature = "cli")]
pub mod picture;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod supervisor;
pub mod system;
