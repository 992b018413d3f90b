//! plan.

pub mod endpoints;
pub mod plan_check;

pub use endpoints::EndpointReport;
