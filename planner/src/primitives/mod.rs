//! Motions that need no search: primitive trajectories pi_S, and transition configurations
//! [Grey 3.2, 4.4.2, 4.4.5].

pub mod gait;
pub mod level_sole;
mod posture_choice;
pub mod step_path;
pub mod step_state;
pub mod step_trajectory;
pub mod transition_configuration;
pub mod transition_pair;
mod tuning;

pub use gait::Gait;
pub use step_path::{HalfSwing, configuration};
pub use step_trajectory::PrimitiveTrajectory;
pub use tuning::FAR_REACHING_POSTURES;
