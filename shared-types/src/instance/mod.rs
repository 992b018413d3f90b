//! The shared memory of one planner, one controller and their clients: the private folder, its
//! locks, iceoryx2's services, wake pipes, requests and observers.

#[cfg(doctest)]
mod attach_page;
pub(crate) mod base_folder;
pub(crate) mod capacity;
pub(crate) mod chunk_counter;
pub(crate) mod dead_nodes;
pub mod description;
pub(crate) mod directory;
pub mod error;
pub mod instance;
pub mod loan_pool;
pub(crate) mod location;
pub(crate) mod lock;
pub(crate) mod making;
pub(crate) mod management_segment;
pub mod observer;
pub mod participant;
pub(crate) mod private;
pub mod requests;
pub mod role_lock;
pub mod role_publisher;
pub mod ros_topics;
pub mod sender;
pub mod services;
pub mod set_points;
#[cfg(test)]
mod tests;
pub(crate) mod token;
pub mod tuning;
pub(crate) mod unfinished;
pub(crate) mod unfinished_watch;
pub mod wake_pipe;

pub use directory::remove_segments;
pub use error::{ChannelError, InstanceError};
pub use instance::Instance;
pub use making::Making;
pub use participant::Participant;
pub use sender::{SenderStatus, SenderTracker, random_id};
pub use services::{RequestServices, Service};
