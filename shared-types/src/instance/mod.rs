//! instance.

pub(crate) mod capacity;
pub mod directory;
pub mod instance;
pub mod loan_pool;
pub(crate) mod lock;
pub mod observer;
pub mod participant;
pub mod requests;
pub mod sender;
pub mod wake_pipe;

pub use directory::remove_segments;
pub use participant::{ChannelError, Participant, RequestServices};
pub use sender::{SenderStatus, SenderTracker, random_id};
