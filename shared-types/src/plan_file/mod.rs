//! Reads, checks and writes plan files.

pub(crate) mod check;
pub mod chunks;
pub(crate) mod keys;
pub mod origin;
pub mod ramps;
pub mod read;
pub mod write;
