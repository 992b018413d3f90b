//! Collision checks of the robot with the world and with itself.

mod body_distance;
pub mod error;
mod keep_out;
pub mod model;
mod pair_survey;
mod robot_bodies;
mod self_pairs;
mod separating_direction;
pub(crate) mod tuning;
mod world_cover;
mod world_shapes;
