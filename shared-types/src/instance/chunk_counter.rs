//! Counts the chunks that a reader has missed.

use crate::message::{Feedback, PlanChunk};

/// A plan and its epoch.
type PlanKey = (u64, u64);

/// Counts the chunks that a reader has missed. Repeated chunks count once.
#[derive(Debug, Clone, Default)]
pub(crate) struct ChunkCounter {
    /// The plan of the last chunk or feedback, and the sequence number that follows the largest
    /// one seen.
    plan: Option<(PlanKey, u64)>,
    /// The session of the last chunk.
    session: u64,
    /// The number of its chunks that the controller has accepted.
    accepted: u64,
    missed: u64,
}

impl ChunkCounter {
    /// Counts a received chunk; those between it and the ones before are missed.
    pub(crate) fn record(&mut self, chunk: &PlanChunk) {
        let key = (chunk.plan_id, chunk.epoch);
        let begins_again = chunk.sequence == 0 && chunk.session != self.session;
        let next = self.begin(key, begins_again);
        self.session = chunk.session;
        self.missed += chunk.sequence.saturating_sub(next);
        self.plan = Some((key, next.max(chunk.sequence + 1)));
    }

    /// The controller has accepted chunks. They have been sent before, so a reader that finds no
    /// more has missed them.
    pub(crate) fn expect(&mut self, feedback: &Feedback) {
        let key = (feedback.plan_id, feedback.epoch);
        // The chunks before a late reader's first one are counted when that comes.
        if self.plan.is_some_and(|(plan, _)| plan == key) {
            self.accepted = self.accepted.max(feedback.next_sequence);
        }
    }

    /// There is no further chunk: the accepted ones that are not received are missed.
    pub(crate) fn settle(&mut self) {
        if let Some((_, next)) = &mut self.plan {
            self.missed += self.accepted.saturating_sub(*next);
            *next = self.accepted.max(*next);
        }
    }

    /// The number of missed chunks.
    pub(crate) fn missed(&self) -> u64 {
        self.missed
    }

    /// The sequence number expected next of a plan, which may be a new one.
    fn begin(&mut self, key: PlanKey, begins_again: bool) -> u64 {
        match self.plan {
            Some((plan, next)) if plan == key && !begins_again => next,
            _ => {
                self.settle();
                self.accepted = 0;
                0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    fn chunk(session: u64, epoch: u64, sequence: u64) -> PlanChunk {
        PlanChunk { session, plan_id: 1, epoch, sequence, ..PlanChunk::zeroed() }
    }

    fn accepting(epoch: u64, next_sequence: u64) -> Feedback {
        Feedback { plan_id: 1, epoch, next_sequence, ..Feedback::zeroed() }
    }

    fn missed_after(chunks: &[(u64, u64, u64)]) -> u64 {
        let mut counter = ChunkCounter::default();
        for &(session, epoch, sequence) in chunks {
            counter.record(&chunk(session, epoch, sequence));
        }
        counter.missed()
    }

    #[test]
    fn gaps_count_and_repetitions_do_not() {
        assert_eq!(missed_after(&[(1, 0, 0), (1, 0, 1), (1, 0, 1), (1, 0, 0), (1, 0, 2)]), 0);
        assert_eq!(missed_after(&[(1, 0, 2), (1, 0, 5)]), 2 + 2);
        assert_eq!(missed_after(&[(1, 0, 0), (2, 0, 1), (2, 0, 2)]), 0, "a planner that goes on");
        assert_eq!(missed_after(&[(1, 0, 0), (1, 0, 1), (2, 0, 0), (2, 0, 1)]), 0, "a plan again");
        assert_eq!(missed_after(&[(1, 0, 0), (1, 1, 0), (1, 1, 2)]), 1, "an epoch begins at 0");
    }

    #[test]
    fn accepted_chunks_at_the_end_count_once_no_chunk_is_left() {
        let mut counter = ChunkCounter::default();
        counter.expect(&accepting(0, 4));
        counter.settle();
        assert_eq!(counter.missed(), 0, "it joined late");
        counter.record(&chunk(1, 0, 4));
        assert_eq!(counter.missed(), 4);
        counter.expect(&accepting(0, 7));
        counter.record(&chunk(1, 0, 5));
        assert_eq!(counter.missed(), 4, "more chunks may wait");
        counter.settle();
        counter.settle();
        assert_eq!(counter.missed(), 5);
    }

    #[test]
    fn the_end_of_a_plan_counts_when_the_next_one_begins() {
        let mut counter = ChunkCounter::default();
        counter.record(&chunk(1, 0, 0));
        counter.expect(&accepting(0, 3));
        counter.record(&chunk(1, 1, 0));
        assert_eq!(counter.missed(), 2);
    }
}
