//! preparation.

pub mod build;
pub mod conditions;
pub(crate) mod expanded_geometry;
pub mod file_format;
pub(crate) mod gait_search;
pub(crate) mod planning_context;
pub(crate) mod primitive_range;
pub(crate) mod primitive_sweep;
pub(crate) mod reach_sweep;
pub(crate) mod reachable_space;
pub(crate) mod shape_slices;
pub(crate) mod step_limits;

pub use conditions::{Necessary, necessary, sufficient, sufficient_pair, sufficient_shift};
pub use file_format::{PreparationError, key};
