//! Worlds: their file format, the validated value and its corrections.

pub mod builder;
pub mod correction;
pub mod load;
pub(crate) mod shape_block;
pub mod world;
pub(crate) mod world_file;
