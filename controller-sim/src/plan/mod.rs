//! The checks on an exported plan.

pub(crate) mod endpoints;
pub mod plan_check;

pub use endpoints::EndpointReport;
