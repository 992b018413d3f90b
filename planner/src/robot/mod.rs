//! robot.

pub(crate) mod ankle_limits;
pub(crate) mod bounding_spheres;
pub mod constrained_projection;
pub mod crouch;
pub mod gravity_torques;
pub mod kinematic_state;
pub mod mechanism;
pub mod posture_ik;
pub(crate) mod single_support;
