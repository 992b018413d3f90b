//! A first robot file from a URDF alone: legs, soles, a standing posture, and which joints are
//! locked.
//!
//! [`RobotDraft::from_urdf`] shows the order; [`text::robot_file`] writes the result with the
//! source of each value.

pub(crate) mod arms;
pub(crate) mod body;
pub mod draft;
pub(crate) mod estimates;
pub(crate) mod foot_choice;
pub(crate) mod foot_search;
pub(crate) mod heading;
pub(crate) mod leg_ik;
pub(crate) mod locks;
pub(crate) mod mirror;
pub mod options;
pub(crate) mod skeleton;
pub(crate) mod sole_search;
pub(crate) mod standing_posture;
#[cfg(test)]
mod tests;
pub mod text;

pub use draft::{DraftEstimates, DraftFoot, Noted, RobotDraft};
pub use options::DraftOptions;
