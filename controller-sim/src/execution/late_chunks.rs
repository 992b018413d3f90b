//! Chunks that are held back at random, as a slow planner or transport would hold them back.

use crate::base::random::uniform;
use crate::execution::tuning::DELAY_MAX;

/// The share of chunks that come late where none is stated.
pub const LATE_SHARE: f64 = 0.2;

/// Which chunks come late, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateChunks {
    /// The seed that decides.
    pub seed: u64,
    /// The share of chunks that come late, 0 to 1.
    pub share: f64,
}

impl LateChunks {
    /// How long a chunk is held back (s); nothing if it comes in time. The same chunk of the same
    /// plan is held back as long in every run.
    pub fn delay(&self, epoch: u64, sequence: u64) -> Option<f64> {
        let random = |key: u64| uniform(self.seed, &[epoch, sequence, key]);
        (random(0) < self.share).then(|| DELAY_MAX * random(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stated_share_of_chunks_comes_late_by_at_most_the_longest_delay() {
        let late = LateChunks { seed: 5, share: 0.3 };
        let delays: Vec<f64> = (0..1000).filter_map(|chunk| late.delay(0, chunk)).collect();
        assert!((250..350).contains(&delays.len()), "{}", delays.len());
        assert!(delays.iter().all(|delay| (0.0..DELAY_MAX).contains(delay)));
        assert_eq!(late.delay(0, 7), late.delay(0, 7));
        assert!((0..100).any(|chunk| late.delay(0, chunk) != late.delay(1, chunk)));
        let never = LateChunks { share: 0.0, ..late };
        assert!((0..100).all(|chunk| never.delay(0, chunk).is_none()));
    }
}
