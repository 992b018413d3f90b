//! Tracks which process id is current on a channel.
//!
//! A killed process leaves messages in flight that may arrive after its successor's. The random id
//! that every process takes at its start tells them apart.

use std::hash::{BuildHasher, Hasher, RandomState};

/// Stale ids that are kept.
const REMEMBERED_MAX: usize = 32;

/// An id for a process's session or instance: random, never 0. It has no influence on a
/// plan.
pub fn random_id() -> u64 {
    RandomState::new().build_hasher().finish().max(1)
}

/// The current sender of a channel and the senders before it.
#[derive(Debug, Clone, Default)]
pub struct SenderTracker {
    current: Option<u64>,
    stale: [Option<u64>; REMEMBERED_MAX],
    stale_count: usize,
}

/// Status of a message's sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SenderStatus {
    /// The sender of the last accepted message.
    Current,
    /// Not seen before; not adopted yet.
    New,
    /// Superseded by a later sender: its message is left over.
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
            self.stale[self.stale_count % REMEMBERED_MAX] = self.current;
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
