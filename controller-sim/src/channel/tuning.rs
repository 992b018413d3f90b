//! Times and probabilities of the transport.

use std::time::Duration;

// Feedback.

/// Time between two heartbeats while there is nothing to read.
pub(crate) const HEARTBEAT_INTERVAL: Duration = Duration::from_millis(1);
/// Time between two cleanings of what dead processes hold, while there is nothing to read.
pub(crate) const CLEANUP_INTERVAL: Duration = Duration::from_millis(500);

// The journal.

/// The last accepted chunks of a plan that the journal keeps. The robot takes no further chunk
/// while it has not passed so many.
pub const JOURNAL_CHUNKS: usize = 32;

// Injected faults.

/// Probability that a feedback message is lost.
pub(crate) const LOSS_PROBABILITY: f64 = 0.2;
/// Probability that the message before it arrives in its place.
pub(crate) const DELAY_PROBABILITY: f64 = 0.2;
