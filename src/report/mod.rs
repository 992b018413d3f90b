//! Events, reports, errors and messages of the commands.

pub mod binding;
pub mod command_error;
pub mod event;
pub(crate) mod liveness;
pub mod margins;
pub mod progress;
pub mod reporter;
pub mod role;
pub mod run_report;
pub mod summary;
pub mod walk_facts;
