//! Which contact forces hold the robot, and what they demand of its joints.

pub(crate) mod contact_load;
pub(crate) mod convex_program;
pub(crate) mod equilibrium;
pub(crate) mod error;
pub(crate) mod hollow_sole;
pub(crate) mod inverse_dynamics;
pub(crate) mod joint_torques;
pub(crate) mod least_squares;
pub(crate) mod resting_contact;
pub(crate) mod simplex;
pub(crate) mod sole_support;
pub(crate) mod tuning;
pub(crate) mod underside;

pub use contact_load::{ContactLoad, FootLoad};
pub use error::CheckerError;
pub use hollow_sole::HollowSole;
