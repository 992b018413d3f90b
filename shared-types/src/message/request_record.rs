//! A request to a serving planner, its progress and how it ended.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::Digest;
use crate::base::limits::REASON_BYTES_MAX;
use crate::message::layout::layout;

/// The state of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum RequestState {
    /// No request has arrived.
    Idle = 0,
    /// The search runs.
    Planning = 1,
    /// The plan is being delivered.
    Delivering = 2,
    /// The controller accepted and executed the whole plan.
    Accepted = 3,
    /// The search found no plan within its work limit.
    NoPlan = 4,
    /// The controller refused a chunk, and planning again found no accepted plan.
    Refused = 5,
    /// A client cancelled it.
    Cancelled = 6,
    /// The request is malformed, or the robot's rest state is unknown.
    Invalid = 7,
    /// The controller sends no feedback.
    ControllerLost = 8,
    /// The robot cannot stand at the start; the planner reports the reason.
    StartInvalid = 9,
    /// The robot cannot stand at the goal; the planner reports the reason.
    GoalInvalid = 10,
    /// Two processes publish feedback as the controller.
    Contradicted = 11,
}

/// A request, its progress and how it ended.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.RequestRecord.v1")]
pub struct RequestRecord {
    /// The client; 0 before the first request.
    pub client: u64,
    /// The number of the client's request.
    pub number: u64,
    /// Number of the plan in the session.
    pub plan_id: u64,
    /// Number of the replan within the plan.
    pub epoch: u64,
    /// Work units of the search so far.
    pub work: u64,
    /// Chunks of the plan; 0 before it is found.
    pub chunks: u64,
    /// Chunks of the plan that the controller has accepted.
    pub accepted: u64,
    /// Digest of the plan's stream; zero before it is found.
    pub digest: Digest,
    /// A [`RequestState`] as its wire value.
    pub state: u32,
    /// Length of `reason`, bytes.
    pub reason_len: u32,
    /// Why the request ended as it did: UTF-8 text.
    pub reason: [u8; REASON_BYTES_MAX],
}

const _: () = assert!(size_of::<RequestRecord>() == 96 + REASON_BYTES_MAX);

layout!(RequestRecord {
    client: u64,
    number: u64,
    plan_id: u64,
    epoch: u64,
    work: u64,
    chunks: u64,
    accepted: u64,
    digest: Digest,
    state: u32,
    reason_len: u32,
    reason: [u8; REASON_BYTES_MAX],
} with []);

impl RequestState {
    /// All states, in wire order.
    pub const ALL: [Self; 12] = [
        Self::Idle,
        Self::Planning,
        Self::Delivering,
        Self::Accepted,
        Self::NoPlan,
        Self::Refused,
        Self::Cancelled,
        Self::Invalid,
        Self::ControllerLost,
        Self::StartInvalid,
        Self::GoalInvalid,
        Self::Contradicted,
    ];
    /// Their names in reports, in wire order.
    const NAMES: [&'static str; 12] = [
        "idle",
        "planning",
        "delivering",
        "accepted",
        "no_plan",
        "refused",
        "cancelled",
        "invalid",
        "controller_lost",
        "start_invalid",
        "goal_invalid",
        "contradicted",
    ];

    /// The state with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        Self::ALL.get(value as usize).copied()
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Whether the request is finished.
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Idle | Self::Planning | Self::Delivering)
    }
}

impl RequestRecord {
    /// The request's state, if the record is well-formed.
    pub fn known_state(&self) -> Option<RequestState> {
        let is_text = self.reason_bytes().is_some_and(|bytes| std::str::from_utf8(bytes).is_ok());
        RequestState::from_wire(self.state).filter(|_| is_text)
    }

    /// Why the request ended as it did; empty where nothing is known.
    pub fn reason(&self) -> &str {
        self.reason_bytes().and_then(|bytes| std::str::from_utf8(bytes).ok()).unwrap_or_default()
    }

    /// Sets the reason; a longer text is cut at a character.
    pub fn set_reason(&mut self, text: &str) {
        let end = (0..=text.len().min(REASON_BYTES_MAX))
            .rev()
            .find(|end| text.is_char_boundary(*end))
            .unwrap_or_default();
        self.reason = [0; REASON_BYTES_MAX];
        self.reason[..end].copy_from_slice(&text.as_bytes()[..end]);
        self.reason_len = end as u32;
    }

    fn reason_bytes(&self) -> Option<&[u8]> {
        self.reason.get(..self.reason_len as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_has_its_wire_value() {
        for state in RequestState::ALL {
            let record = RequestRecord { state: state as u32, ..RequestRecord::zeroed() };
            assert_eq!(record.known_state(), Some(state));
            assert!(!state.name().is_empty());
        }
        let last = RequestState::ALL.iter().map(|state| *state as u32).max();
        assert_eq!(last.and_then(|last| RequestState::from_wire(last + 1)), None);
        assert!(RequestState::Accepted.is_final() && !RequestState::Delivering.is_final());
    }

    #[test]
    fn a_reason_is_cut_at_a_character_and_a_broken_one_is_recognized() {
        let mut record = RequestRecord::zeroed();
        record.set_reason("too far");
        assert_eq!(record.reason(), "too far");
        record.set_reason(&"ä".repeat(REASON_BYTES_MAX));
        assert_eq!(record.reason(), "ä".repeat(REASON_BYTES_MAX / 2));
        record.set_reason(&format!("a{}", "ä".repeat(REASON_BYTES_MAX)));
        assert_eq!(record.reason().len(), REASON_BYTES_MAX - 1);
        let mut broken = record;
        broken.reason[0] = 0xff;
        assert_eq!((broken.known_state(), broken.reason()), (None, ""));
        let too_long = RequestRecord { reason_len: REASON_BYTES_MAX as u32 + 1, ..record };
        assert_eq!((too_long.known_state(), too_long.reason()), (None, ""));
    }
}
