//! plan_file.

pub(crate) mod check;
pub mod read;
pub mod write;
