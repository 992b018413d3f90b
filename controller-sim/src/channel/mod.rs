//! channel.

pub(crate) mod fault_injection;
pub(crate) mod journal;
pub mod plan_subscriber;
pub mod state_publisher;
pub(crate) mod stream_state;

pub use state_publisher::StatePublisher;
