//! Requests to a serving planner, and their status.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::Digest;
use crate::config::scenario::StancePose;
use crate::message::crc::WithCrc;
use crate::message::layout::layout;

/// The layout version in [`PlanRequest::schema`].
pub const REQUEST_SCHEMA: u64 = 1;
/// The layout version in [`PlanStatus::schema`].
pub const STATUS_SCHEMA: u64 = 1;
/// Largest coordinate of a stance, m; also its largest heading, rad.
const COORDINATE_MAX: f64 = 1e4;
/// Largest lateral distance between the soles of a stance, m.
const STANCE_WIDTH_MAX: f64 = 10.0;

/// The kind of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum RequestKind {
    /// Walk from the robot's rest state to `goal`; from `start` if the rest state is unknown.
    Goal = 1,
    /// Walk from `start` to `goal`. The robot accepts the plan only if it stands at `start` or its
    /// rest state is unknown.
    StartAndGoal = 2,
    /// Cancel the current search or delivery. The robot stays at the end of the last executed
    /// chunk.
    Cancel = 3,
    /// Plan again from the robot's rest state to the last requested goal, with `seed`.
    Replan = 4,
}

/// A [`StancePose`] in shared memory.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.StancePoseData.v1")]
pub struct StancePoseData {
    /// Midpoint of the two sole frames in the world, m.
    pub position: [f64; 3],
    /// Heading about the world's z axis, rad.
    pub yaw: f64,
    /// Lateral distance between the two sole frames, m.
    pub stance_width: f64,
}

/// A client's request. The client sends it repeatedly until a [`PlanStatus`] names it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.PlanRequest.v1")]
pub struct PlanRequest {
    /// [`REQUEST_SCHEMA`].
    pub schema: u64,
    /// The client's id: random, never 0.
    pub client: u64,
    /// Number of the client's request, from 1.
    pub number: u64,
    /// The seed of the search.
    pub seed: u64,
    /// Most work units of the search, at most those of the scenario; 0 stands for the scenario's.
    pub work_max: u64,
    /// A [`RequestKind`] as its wire value.
    pub kind: u32,
    /// CRC-32 (IEEE) of all bytes of the message with this field zero.
    pub crc: u32,
    /// Start stance, for kinds that have one.
    pub start: StancePoseData,
    /// Goal stance, for kinds that have one.
    pub goal: StancePoseData,
}

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
}

/// The planner's status of its current request.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.PlanStatus.v1")]
pub struct PlanStatus {
    /// [`STATUS_SCHEMA`].
    pub schema: u64,
    /// The planner's session.
    pub session: u64,
    /// The client of the current request; 0 before the first request.
    pub client: u64,
    /// The number of the current request.
    pub number: u64,
    /// Number of this status message in the session.
    pub count: u64,
    /// Number of the plan in the session.
    pub plan_id: u64,
    /// Number of the replan within the plan.
    pub epoch: u64,
    /// Work units of the search so far.
    pub work: u64,
    /// Chunks of the plan; 0 before it is found.
    pub chunks: u64,
    /// Chunks that the controller has accepted.
    pub accepted: u64,
    /// Digest of the plan's stream; zero before it is found.
    pub digest: Digest,
    /// A [`RequestState`] as its wire value.
    pub state: u32,
    /// CRC-32 (IEEE) of all bytes of the message with this field zero.
    pub crc: u32,
}

const _: () = assert!(size_of::<StancePoseData>() == 40);
const _: () = assert!(size_of::<PlanRequest>() == 48 + 2 * size_of::<StancePoseData>());
const _: () = assert!(size_of::<PlanStatus>() == 120);

layout!(StancePoseData { position: [f64; 3], yaw: f64, stance_width: f64 } with []);
layout!(PlanRequest {
    schema: u64,
    client: u64,
    number: u64,
    seed: u64,
    work_max: u64,
    kind: u32,
    crc: u32,
    start: StancePoseData,
    goal: StancePoseData,
} with [StancePoseData]);
layout!(PlanStatus {
    schema: u64,
    session: u64,
    client: u64,
    number: u64,
    count: u64,
    plan_id: u64,
    epoch: u64,
    work: u64,
    chunks: u64,
    accepted: u64,
    digest: Digest,
    state: u32,
    crc: u32,
} with []);

impl RequestKind {
    /// The kind with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        [Self::Goal, Self::StartAndGoal, Self::Cancel, Self::Replan]
            .into_iter()
            .find(|kind| *kind as u32 == value)
    }
}

impl RequestState {
    /// All states, in wire order.
    pub const ALL: [Self; 11] = [
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
    ];
    /// Their names in reports, in wire order.
    const NAMES: [&'static str; 11] = [
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

impl From<StancePose> for StancePoseData {
    fn from(stance: StancePose) -> Self {
        Self {
            position: stance.position.to_array(),
            yaw: stance.yaw,
            stance_width: stance.stance_width,
        }
    }
}

impl StancePoseData {
    /// The stance, if its numbers are in range.
    pub fn stance_pose(&self) -> Option<StancePose> {
        let bounded =
            self.position.iter().chain([&self.yaw]).all(|number| number.abs() <= COORDINATE_MAX);
        let has_width = self.stance_width > 0.0 && self.stance_width <= STANCE_WIDTH_MAX;
        (bounded && has_width).then(|| StancePose {
            position: self.position.into(),
            yaw: self.yaw,
            stance_width: self.stance_width,
        })
    }
}

impl WithCrc for PlanRequest {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl WithCrc for PlanStatus {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl PlanRequest {
    /// The request's kind, if the request is undamaged and well-formed.
    pub fn known_kind(&self) -> Option<RequestKind> {
        let kind = RequestKind::from_wire(self.kind)?;
        let start = kind != RequestKind::StartAndGoal || self.start.stance_pose().is_some();
        let goal = !matches!(kind, RequestKind::Goal | RequestKind::StartAndGoal)
            || self.goal.stance_pose().is_some();
        let has_ids = self.schema == REQUEST_SCHEMA && self.client != 0 && self.number != 0;
        (has_ids && start && goal && self.crc_matches()).then_some(kind)
    }
}

impl PlanStatus {
    /// The status's state, if the status is undamaged and well-formed.
    pub fn known_state(&self) -> Option<RequestState> {
        let well_formed = self.schema == STATUS_SCHEMA && self.session != 0 && self.crc_matches();
        RequestState::from_wire(self.state).filter(|_| well_formed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_crc<M: WithCrc>(mut message: M) -> M {
        message.write_crc();
        message
    }

    #[test]
    fn malformed_requests_have_no_kind() {
        let stance = StancePoseData { position: [1.0, 2.0, 0.0], yaw: 0.5, stance_width: 0.2 };
        let request = PlanRequest {
            schema: REQUEST_SCHEMA,
            client: 3,
            number: 1,
            kind: 2,
            start: stance,
            goal: stance,
            ..PlanRequest::zeroed()
        };
        assert_eq!(request.known_kind(), None, "without a CRC");
        assert_eq!(with_crc(request).known_kind(), Some(RequestKind::StartAndGoal));
        assert_eq!(StancePoseData::from(stance.stance_pose().unwrap()), stance);
        let odd = StancePoseData { yaw: f64::NAN, ..stance };
        let bad = [
            PlanRequest { schema: 2, ..request },
            PlanRequest { client: 0, ..request },
            PlanRequest { number: 0, ..request },
            PlanRequest { kind: 5, ..request },
            PlanRequest { kind: 0, ..request },
            PlanRequest { start: odd, ..request },
            PlanRequest { goal: odd, ..request },
            PlanRequest { goal: StancePoseData { stance_width: 0.0, ..stance }, ..request },
            PlanRequest { goal: StancePoseData { position: [1e9, 0.0, 0.0], ..stance }, ..request },
        ];
        assert!(bad.iter().all(|request| with_crc(*request).known_kind().is_none()));
        assert_eq!(
            with_crc(PlanRequest { kind: 3, goal: odd, ..request }).known_kind(),
            Some(RequestKind::Cancel)
        );
    }

    #[test]
    fn every_state_has_its_wire_value() {
        for state in RequestState::ALL {
            let status = PlanStatus {
                schema: STATUS_SCHEMA,
                session: 1,
                state: state as u32,
                ..PlanStatus::zeroed()
            };
            assert_eq!((status.known_state(), with_crc(status).known_state()), (None, Some(state)));
            assert!(!state.name().is_empty());
        }
        let last = RequestState::ALL.iter().map(|state| *state as u32).max();
        assert_eq!(last.and_then(|last| RequestState::from_wire(last + 1)), None);
        assert!(RequestState::Accepted.is_final() && !RequestState::Delivering.is_final());
    }
}
