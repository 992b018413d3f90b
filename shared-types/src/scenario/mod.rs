//! Scenario files.

pub mod load;
