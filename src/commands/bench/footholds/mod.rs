//! `surefoot bench footholds`: success rates of foot placement sampling.

pub mod footholds_bench;
pub mod plot;
pub mod queries;
