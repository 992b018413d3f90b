//! collision.

pub mod model;
pub(crate) mod robot_bodies;
pub(crate) mod self_pairs;
pub(crate) mod separating_direction;
pub(crate) mod world_shapes;
