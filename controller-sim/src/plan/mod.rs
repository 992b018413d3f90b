//! The checks on an exported plan.

pub(crate) mod endpoints;
pub mod plan_check;
pub mod problem;

pub use endpoints::EndpointReport;
pub use problem::Problem;
