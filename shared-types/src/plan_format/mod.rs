//! The exported plan format `biped-plan/1` as serde types.

pub mod blocks;
