//! The constraints on every configuration and motion of a plan, and the modes in which they apply.

pub mod constraints;
pub mod foothold;
pub mod mode;
pub mod mode_state;
pub mod rejection;
pub(crate) mod tuning;
pub mod waist;
