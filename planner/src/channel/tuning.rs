//! Constants of the sender that decide how fast chunks are delivered, and when a controller counts
//! as lost.

use std::time::Duration;

/// Time without progress after which unacknowledged chunks are sent again, if the controller is
/// idle.
pub(crate) const RESEND_AFTER: Duration = Duration::from_millis(20);
/// Consecutive idle heartbeats without progress that prove the loss of a chunk. A controller sends
/// them only if it has nothing to read.
pub(crate) const IDLE_HEARTBEATS: u64 = 3;
/// Go-backs without progress after which the controller counts as lost: its feedback arrives, but
/// no chunk reaches it.
pub(crate) const GO_BACKS_MAX: u32 = 500;
/// Feedback messages that must repeat a claim that ends the delivery. A controller publishes one
/// every millisecond.
pub(crate) const CONFIRMATIONS: u32 = 3;
/// Time after which such a claim counts without repetition, because the controller is silent.
pub(crate) const CONFIRM_TIME: Duration = Duration::from_millis(500);
/// Contradictions after which two processes publish feedback as the controller. A killed controller
/// and its successor contradict each other once or twice.
pub(crate) const CONTRADICTIONS_MAX: u32 = 8;
/// Feedback messages that are received between two chunks or polls: twice those that all publishers
/// of a service can have waiting, so that a flood of others' delays no chunk.
pub(crate) const FEEDBACK_PER_POLL_MAX: usize = 16;
/// Consecutive lower acknowledgements after which they count.
pub(crate) const LOWER_ACKNOWLEDGEMENTS: u32 = 3;
/// Silence of the controller after which another one may take its place.
pub(crate) const TAKEOVER_SILENCE: Duration = Duration::from_millis(20);
/// Go-backs without progress after which the ports are made anew: iceoryx2 does not repeat a
/// connection that failed.
pub(crate) const RECONNECT_GO_BACKS: u32 = 25;
/// Silence, or time without a reader of the chunks, after which the ports are made anew. Repeated.
pub(crate) const RECONNECT_INTERVAL: Duration = Duration::from_secs(1);
/// Longest time in which the controller publishes feedback and no reader takes the chunks.
pub(crate) const NO_READER_MAX: Duration = Duration::from_secs(10);
/// Time without feedback after which the resources of dead processes are freed, repeatedly.
pub(crate) const CLEANUP_INTERVAL: Duration = Duration::from_millis(200);
/// Default time without feedback after which the controller counts as lost.
pub(crate) const LOST_AFTER: Duration = Duration::from_secs(30);
/// Longest wait for the wake pipe.
pub(crate) const WAIT_MAX: Duration = Duration::from_millis(4);
/// Longest time between two polls that counts as silence of the controller. A sender that was
/// stopped for longer may have missed feedback.
pub(crate) const POLL_GAP_MAX: Duration = Duration::from_millis(100);
/// Motion in flight to the controller, s. A request to a robot that moves takes effect after it.
pub(crate) const HORIZON_SECONDS: f64 = 1.0;
