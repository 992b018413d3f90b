//! footholds.

pub mod footholds_bench;
pub mod plot;
pub mod queries;
