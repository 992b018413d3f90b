//! The planner's end of the transport: sends chunks and receives feedback.

pub mod plan_publisher;
pub mod send_window;
mod tuning;
