//! Forward kinematics of the robot's tree, and inverse kinematics of a leg: in closed form if the
//! leg's axes allow it, by a bounded Newton iteration otherwise.

pub(crate) mod angle_interval;
pub(crate) mod closed_form;
pub mod forward;
pub(crate) mod least_norm;
pub mod leg;
mod leg_chain;
pub(crate) mod leg_joint;
pub(crate) mod newton;
mod newton_step;
pub mod tree;
mod tuning;

pub use forward::Kinematics;
pub use leg::Leg;
pub use tree::KinematicTree;
