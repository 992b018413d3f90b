//! Who speaks now, and who has been replaced.
//!
//! A killed process leaves messages in flight that may arrive after its successor's. They are told
//! apart by the id that every process draws at its start.

use std::hash::{BuildHasher, Hasher, RandomState};

/// How many replaced ids are remembered.
const REMEMBERED_MAX: usize = 32;

/// An id for a process's session or instance: random, never 0. It has no influence on what is
/// planned.
pub fn draw_id() -> u64 {
    RandomState::new().build_hasher().finish().max(1)
}

/// The current speaker of a channel and those before it.
#[derive(Debug, Clone, Default)]
pub struct Succession {
    current: Option<u64>,
    replaced: [Option<u64>; REMEMBERED_MAX],
    replacements: usize,
}

/// What a message's sender is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// The one who spoke last.
    Current,
    /// Somebody not heard before; still to be enthroned.
    New,
    /// One that was replaced: its message is a leftover.
    Replaced,
}

impl Succession {
    /// The current speaker.
    pub fn current(&self) -> Option<u64> {
        self.current
    }

    /// What `id` is.
    pub fn rank(&self, id: u64) -> Rank {
        if self.current == Some(id) {
            Rank::Current
        } else if self.replaced.contains(&Some(id)) {
            Rank::Replaced
        } else {
            Rank::New
        }
    }

    /// Makes `id` the current speaker; the one before it is replaced.
    pub fn enthrone(&mut self, id: u64) {
        if self.current.is_some() && self.current != Some(id) {
            self.replaced[self.replacements % REMEMBERED_MAX] = self.current;
            self.replacements += 1;
        }
        self.current = Some(id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replaced_one_stays_replaced() {
        let mut succession = Succession::default();
        assert_eq!(succession.rank(1), Rank::New);
        succession.enthrone(1);
        succession.enthrone(1);
        assert_eq!(succession.rank(1), Rank::Current);
        succession.enthrone(2);
        assert_eq!(
            (succession.rank(1), succession.rank(2), succession.rank(3)),
            (Rank::Replaced, Rank::Current, Rank::New)
        );
    }
}
