//! ROS 2 messages: their definitions (ros2msg), their encoding (CDR), and those of a plan.

pub mod cdr;
pub mod foxglove;
pub mod frames;
pub mod messages;
pub mod ros_type;
pub mod scene;
pub mod state;
pub mod trajectories;
pub mod visualization;
