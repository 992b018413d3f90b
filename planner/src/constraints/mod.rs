//! constraints.

pub mod constraints;
pub mod foothold;
