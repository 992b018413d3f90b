//! thesis.

pub mod published;
pub mod report;
pub mod thesis_bench;
