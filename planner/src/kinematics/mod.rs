//! Forward kinematics of the whole tree, and inverse kinematics of a leg: closed-form where the
//! leg's axes meet as they must, a bounded Newton iteration otherwise.

pub(crate) mod angle_interval;

pub use forward::Kinematics;
pub use leg::Leg;
pub use tree::KinematicTree;

pub mod closed_form;
pub mod forward;
pub mod least_norm;
pub mod leg;
pub mod newton;
pub mod tree;
