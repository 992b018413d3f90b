//! Words that get lost or come late on purpose: what a planner must bear.

use surefoot_shared_types::message::Feedback;

use crate::draw;

/// The share of words that are lost, and the share that come one word late.
const LOST_SHARE: f64 = 0.2;
const LATE_SHARE: f64 = 0.2;

/// Loses and delays words.
#[derive(Debug)]
pub(super) struct Lateness {
    seed: u64,
    before: Option<Feedback>,
}

impl Lateness {
    /// The losses of a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, before: None }
    }

    /// What arrives in place of a word: itself, the one before it, or nothing.
    pub(super) fn arriving(&mut self, word: Feedback) -> Option<Feedback> {
        let before = self.before.replace(word);
        match draw::unit(self.seed, &[word.count]) {
            share if share < LOST_SHARE => None,
            share if share < LOST_SHARE + LATE_SHARE => before,
            _ => Some(word),
        }
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn some_words_are_lost_and_some_come_late() {
        let mut lateness = Lateness::new(7);
        let (mut lost, mut late) = (0, 0);
        for count in 1..=1000 {
            match lateness.arriving(Feedback { count, ..Feedback::zeroed() }) {
                None => lost += 1,
                Some(word) if word.count < count => late += 1,
                Some(word) => assert_eq!(word.count, count),
            }
        }
        assert!(
            (150..250).contains(&lost) && (150..250).contains(&late),
            "{lost} lost, {late} late"
        );
    }
}
