//! The planner's end of the transport: sends chunks and receives feedback.

pub mod chunk_source;
pub mod plan_publisher;
pub mod send_window;
mod stream_outline;
mod tuning;
