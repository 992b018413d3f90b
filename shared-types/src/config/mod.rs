//! config.

pub(crate) mod content_digest;
pub mod load;
pub mod planner;
pub mod scenario;
pub(crate) mod validation;

pub use planner::{CheckerConfig, PlannerConfig};
