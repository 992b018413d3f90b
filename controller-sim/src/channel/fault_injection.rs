//! Injected faults: lost and delayed feedback, which a planner must tolerate.

use surefoot_shared_types::message::Feedback;

use crate::base::random;
use crate::channel::tuning::{DELAY_PROBABILITY, LOSS_PROBABILITY};

/// Loses and delays feedback messages.
#[derive(Debug)]
pub(crate) struct FaultInjection {
    seed: u64,
    previous: Option<Feedback>,
}

impl FaultInjection {
    /// The faults of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, previous: None }
    }

    /// What arrives in place of a message: itself, the one before it, or nothing.
    pub(crate) fn delivered(&mut self, feedback: Feedback) -> Option<Feedback> {
        let previous = self.previous.replace(feedback);
        match random::uniform(self.seed, &[feedback.count]) {
            share if share < LOSS_PROBABILITY => None,
            share if share < LOSS_PROBABILITY + DELAY_PROBABILITY => previous,
            _ => Some(feedback),
        }
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn some_messages_are_lost_and_some_are_delayed() {
        let mut faults = FaultInjection::new(7);
        let (mut lost, mut delayed) = (0, 0);
        for count in 1..=1000 {
            match faults.delivered(Feedback { count, ..Feedback::zeroed() }) {
                None => lost += 1,
                Some(feedback) if feedback.count < count => delayed += 1,
                Some(feedback) => assert_eq!(feedback.count, count),
            }
        }
        assert!(
            (150..250).contains(&lost) && (150..250).contains(&delayed),
            "{lost} lost, {delayed} delayed"
        );
    }
}
