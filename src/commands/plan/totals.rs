//! Counts of the chunks of all epochs of a plan.

use surefoot_planner::channel::plan_publisher::Delivery;

use crate::report::event::Delivered;

/// The chunks of all epochs.
#[derive(Debug, Default)]
pub(crate) struct Totals {
    sent: u64,
    resent: u64,
    accepted: u64,
    withdrawn: u64,
    feedback_dropped: u64,
    /// Number of replans.
    pub(crate) replans: u32,
}

impl Totals {
    /// Adds a delivery.
    pub(crate) fn add(&mut self, delivery: &Delivery) {
        self.sent += delivery.sent;
        self.resent += delivery.resent;
        self.accepted += delivery.accepted;
        self.feedback_dropped += delivery.other_senders;
    }

    /// Counts a plan that another one replaces.
    pub(crate) fn withdraw(&mut self, delivery: &Delivery) {
        self.withdrawn += delivery.sent.saturating_sub(delivery.resent + delivery.accepted);
        self.replans += 1;
    }

    /// The result of all deliveries, of which `last` is the last.
    pub(crate) fn delivered(&self, last: &Delivery) -> Delivered {
        let Self { sent, resent, accepted, withdrawn, feedback_dropped, .. } = *self;
        Delivered { sent, resent, accepted, withdrawn, feedback_dropped, ..Delivered::from(last) }
    }
}
