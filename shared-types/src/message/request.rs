//! Requests to a serving planner, and the planner's status.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::limits::REQUEST_ENDS_MAX;
use crate::config::scenario::StancePose;
use crate::message::crc::WithCrc;
use crate::message::layout::layout;
use crate::message::request_record::{RequestRecord, RequestState};

/// The layout version in [`PlanRequest::schema`].
pub const REQUEST_SCHEMA: u64 = 1;
/// The layout version in [`PlanStatus::schema`].
pub const STATUS_SCHEMA: u64 = 2;
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
    /// Lateral distance between the two sole frames, m; in a request 0 stands for that of the goal
    /// in the planner's scenario.
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

/// The status of a planner that serves: its current request, and how the last ones ended.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.PlanStatus.v2")]
pub struct PlanStatus {
    /// [`STATUS_SCHEMA`].
    pub schema: u64,
    /// The planner's session.
    pub session: u64,
    /// Number of this status message in the session.
    pub count: u64,
    /// The current request, or the last one.
    pub current: RequestRecord,
    /// Number of used entries of `ends`.
    pub ends_len: u32,
    /// CRC-32 (IEEE) of all bytes of the message with this field zero.
    pub crc: u32,
    /// The requests that ended last, oldest first.
    pub ends: [RequestRecord; REQUEST_ENDS_MAX],
}

const _: () = assert!(size_of::<StancePoseData>() == 40);
const _: () = assert!(size_of::<PlanRequest>() == 48 + 2 * size_of::<StancePoseData>());
const _: () =
    assert!(size_of::<PlanStatus>() == 32 + (REQUEST_ENDS_MAX + 1) * size_of::<RequestRecord>());

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
    count: u64,
    current: RequestRecord,
    ends_len: u32,
    crc: u32,
    ends: [RequestRecord; REQUEST_ENDS_MAX],
} with [RequestRecord]);

impl RequestKind {
    /// The kind with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        [Self::Goal, Self::StartAndGoal, Self::Cancel, Self::Replan]
            .into_iter()
            .find(|kind| *kind as u32 == value)
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
    /// The stance of a request, if its numbers are in range; `usual_width` takes the place of a
    /// width of 0.
    pub fn requested_pose(&self, usual_width: f64) -> Option<StancePose> {
        let is_usual = self.stance_width == 0.0;
        let stance_width = if is_usual { usual_width } else { self.stance_width };
        Self { stance_width, ..*self }.stance_pose()
    }

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

    /// Whether the numbers of a request are numbers. A planner that serves answers those that are
    /// out of range.
    fn is_finite(&self) -> bool {
        let numbers = self.position.iter().chain([&self.yaw, &self.stance_width]);
        numbers.copied().all(f64::is_finite)
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
        let start = kind != RequestKind::StartAndGoal || self.start.is_finite();
        let goal =
            !matches!(kind, RequestKind::Goal | RequestKind::StartAndGoal) || self.goal.is_finite();
        let has_ids = self.schema == REQUEST_SCHEMA && self.client != 0 && self.number != 0;
        (has_ids && start && goal && self.crc_matches()).then_some(kind)
    }
}

impl PlanStatus {
    /// The current request's state, if the status is undamaged and well-formed.
    pub fn known_state(&self) -> Option<RequestState> {
        let well_formed = self.schema == STATUS_SCHEMA
            && self.session != 0
            && self.ends_len as usize <= REQUEST_ENDS_MAX
            && self.crc_matches()
            && self.ends().iter().all(|end| end.known_state().is_some());
        self.current.known_state().filter(|_| well_formed)
    }

    /// The used entries of `ends`.
    pub fn ends(&self) -> &[RequestRecord] {
        &self.ends[..(self.ends_len as usize).min(REQUEST_ENDS_MAX)]
    }

    /// The record of a client's request, if it is the current one or one that ended last.
    pub fn record_of(&self, client: u64, number: u64) -> Option<&RequestRecord> {
        let is_asked = |record: &&RequestRecord| (record.client, record.number) == (client, number);
        Some(&self.current).filter(is_asked).or_else(|| self.ends().iter().rev().find(is_asked))
    }

    /// Adds the current request to those that ended; the oldest one is dropped where they are full.
    pub fn record_end(&mut self) {
        let mut len = self.ends().len();
        if len == REQUEST_ENDS_MAX {
            self.ends.rotate_left(1);
            len -= 1;
        }
        self.ends[len] = self.current;
        self.ends_len = len as u32 + 1;
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
        let usual = StancePoseData { stance_width: 0.0, ..stance };
        assert_eq!(usual.requested_pose(0.3).unwrap().stance_width, 0.3);
        let negative = StancePoseData { stance_width: -0.1, ..stance };
        let far = StancePoseData { position: [1e9, 0.0, 0.0], ..stance };
        assert!([negative, far].iter().all(|stance| stance.requested_pose(0.3).is_none()));
        let request = PlanRequest { goal: usual, ..request };
        assert_eq!(with_crc(request).known_kind(), Some(RequestKind::StartAndGoal));
        let odd = StancePoseData { yaw: f64::NAN, ..stance };
        let bad = [
            PlanRequest { schema: 2, ..request },
            PlanRequest { client: 0, ..request },
            PlanRequest { number: 0, ..request },
            PlanRequest { kind: 5, ..request },
            PlanRequest { kind: 0, ..request },
            PlanRequest { start: odd, ..request },
            PlanRequest { goal: odd, ..request },
            PlanRequest { goal: StancePoseData { stance_width: f64::NAN, ..stance }, ..request },
        ];
        assert!(bad.iter().all(|request| with_crc(*request).known_kind().is_none()));
        assert_eq!(
            with_crc(PlanRequest { kind: 3, goal: odd, ..request }).known_kind(),
            Some(RequestKind::Cancel)
        );
    }

    #[test]
    fn a_status_names_the_current_request_and_the_last_ends() {
        let mut status = PlanStatus { schema: STATUS_SCHEMA, session: 1, ..PlanStatus::zeroed() };
        assert_eq!(status.known_state(), None, "without a CRC");
        for number in 1..=20 {
            status.current = RequestRecord { client: 7, number, ..RequestRecord::zeroed() };
            status.current.state = RequestState::Accepted as u32;
            status.record_end();
        }
        let number_of = |number| status.record_of(7, number).map(|record| record.number);
        assert_eq!(status.ends().len(), REQUEST_ENDS_MAX);
        assert_eq!((number_of(4), number_of(5), number_of(20)), (None, Some(5), Some(20)));
        assert_eq!(status.record_of(8, 20), None);
        assert_eq!(with_crc(status).known_state(), Some(RequestState::Accepted));
        let too_many = PlanStatus { ends_len: REQUEST_ENDS_MAX as u32 + 1, ..status };
        assert_eq!(with_crc(too_many).known_state(), None);
        let mut odd_end = status;
        odd_end.ends[3].state = 99;
        assert_eq!(with_crc(odd_end).known_state(), None);
    }
}
