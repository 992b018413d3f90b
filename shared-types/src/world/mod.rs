//! world.

pub mod correction;
pub mod load;
pub(crate) mod shape_block;
pub mod world;
pub(crate) mod world_file;
