//! primitives.

pub mod gait;
pub mod level_sole;
pub mod step_path;
pub mod step_state;
pub mod step_trajectory;
pub mod transition_configuration;

pub use gait::Gait;
pub use step_path::{HalfSwing, configuration};
pub use step_trajectory::PrimitiveTrajectory;
