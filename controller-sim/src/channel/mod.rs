//! The controller's end of the transport.

pub(crate) mod fault_injection;
pub(crate) mod journal;
pub mod plan_subscriber;
pub(crate) mod state_publisher;
pub(crate) mod stream_state;
pub(crate) mod tuning;
pub(crate) mod walk_journal;

pub use state_publisher::StatePublisher;
pub use stream_state::{ReceiverStats, Refusal, WalkProgress};
pub use tuning::JOURNAL_CHUNKS;
pub use walk_journal::WalkJournal;
