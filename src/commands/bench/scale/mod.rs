//! scale.

pub mod plot;
pub mod scale_bench;
