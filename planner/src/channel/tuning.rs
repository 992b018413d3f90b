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
