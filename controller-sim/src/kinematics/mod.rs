//! Forward kinematics of the robot, and inverse kinematics of one leg.

pub mod forward;
pub(crate) mod leg_ik;
pub(crate) mod trajectory;
