//! All data that is fixed before a search: computed once per robot, from the robot alone
//! [Grey 4.1.1, 4.2.1, 4.4.5].
//!
//! [`build()`] computes the reachable space R of each leg, the gait of the primitive trajectories
//! with the range R_S of placement pairs that they hold over, the expanded geometry around them,
//! and the step limits. [`Preparation`] reads the result. [`necessary`] and [`sufficient`] evaluate
//! C_N and C_S with it.

mod build;
mod conditions;
mod data;
mod error;
mod expanded_geometry;
mod file_format;
mod gait_search;
pub(crate) mod planning_context;
mod primitive_range;
mod primitive_sweep;
mod reach_sweep;
mod reachable_space;
mod shape_slices;
mod span;
pub(crate) mod step_limits;
mod tuning;

pub use build::{build, prepare};
pub use conditions::{Necessary, necessary, sufficient, sufficient_pair, sufficient_shift};
pub use data::Preparation;
pub use error::{BuildError, PreparationError};
pub use expanded_geometry::{Bounds, ExpandedGeometry};
pub use file_format::key;
pub use primitive_range::PairRange;
pub use reachable_space::{Block, ReachableSpace};
pub use step_limits::StepLimits;
