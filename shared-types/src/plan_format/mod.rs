//! plan_format.

pub mod blocks;
