//! chunk.

pub(crate) mod continuity;
pub mod message_check;

pub use message_check::Identity;
