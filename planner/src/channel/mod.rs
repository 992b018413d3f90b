//! channel.

pub mod plan_publisher;
pub(crate) mod send_window;
