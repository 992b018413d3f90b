//! Tracks which process id is current on a channel.
//!
//! A killed process leaves messages in flight, which may arrive after its successor's. The random
//! id that every process draws at its start distinguishes them.

use std::hash::{BuildHasher, Hasher, RandomState};

use crate::instance::tuning::STALE_SENDERS_MAX;

/// A random id of a planner's session, a controller or a client, never 0. No plan depends on it.
pub fn random_id() -> u64 {
    RandomState::new().build_hasher().finish().max(1)
}

/// The current sender of a channel and the senders before it.
#[derive(Debug, Clone, Default)]
pub struct SenderTracker {
    current: Option<u64>,
    stale: [Option<u64>; STALE_SENDERS_MAX],
    stale_count: usize,
}

/// Status of a message's sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SenderStatus {
    /// The sender of the last accepted message.
    Current,
    /// A sender that was never adopted.
    New,
    /// A sender before the current one: its message is left over.
    Stale,
}

impl SenderTracker {
    /// The current sender.
    pub fn current(&self) -> Option<u64> {
        self.current
    }

    /// Status of `id`.
    pub fn status(&self, id: u64) -> SenderStatus {
        if self.current == Some(id) {
            SenderStatus::Current
        } else if self.stale.contains(&Some(id)) {
            SenderStatus::Stale
        } else {
            SenderStatus::New
        }
    }

    /// Makes `id` the current sender; the one before it becomes stale.
    pub fn adopt(&mut self, id: u64) {
        if self.current.is_some() && self.current != Some(id) {
            self.stale[self.stale_count % STALE_SENDERS_MAX] = self.current;
            self.stale_count += 1;
        }
        self.current = Some(id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stale_sender_stays_stale() {
        let mut tracker = SenderTracker::default();
        assert_eq!(tracker.status(1), SenderStatus::New);
        tracker.adopt(1);
        tracker.adopt(1);
        assert_eq!(tracker.status(1), SenderStatus::Current);
        tracker.adopt(2);
        assert_eq!(
            (tracker.status(1), tracker.status(2), tracker.status(3)),
            (SenderStatus::Stale, SenderStatus::Current, SenderStatus::New)
        );
    }
}
