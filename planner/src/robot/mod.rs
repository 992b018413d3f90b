//! The robot compiled once, its kinematic state, and the postures that it takes.

pub(crate) mod ankle_limits;
pub(crate) mod bounding_spheres;
pub mod configuration;
pub mod constrained_projection;
pub mod crouch;
pub(crate) mod free_joints;
pub mod gravity_torques;
pub mod inverse_dynamics;
pub mod kinematic_state;
pub mod mass_tree;
pub mod mechanism;
pub mod posture_ik;
pub mod single_support;
pub(crate) mod sole;
mod tuning;
mod underside;
