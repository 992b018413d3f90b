//! plan.

pub(crate) mod chunk_builder;
pub mod self_check;
pub(crate) mod time_parameterization;
