//! Whether a received chunk is a sound message, and whether its contacts legally continue those of
//! the robot.

pub(crate) mod continuity;
pub(crate) mod message_check;

pub use message_check::{Identity, check_content};
