//! Scenarios: their file format, the parameters of planner, checker and execution, and the
//! relations between them.

pub mod builder;
pub(crate) mod content_digest;
pub mod execution;
pub mod parameter;
pub mod parameter_lines;
pub mod parameters;
pub mod planner;
pub mod scenario;
pub mod scenario_source;
pub(crate) mod validation;

pub use execution::{ExecutionConfig, MotionKind};
pub use planner::{CheckerConfig, PlannerConfig};
