//! kinematics.

pub mod forward;
pub(crate) mod leg_ik;
