//! The controller's feedback: accepted chunks, a refused chunk, and the state of the robot.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::Digest;
use crate::base::limits::CORRECTIONS_MAX;
use crate::message::correction::WorldCorrection;
use crate::message::crc::WithCrc;
use crate::message::layout::layout;
use crate::message::rest_state::RestState;

/// The layout version in [`Feedback::schema`].
pub const FEEDBACK_SCHEMA: u64 = 5;

/// The checks of a chunk: the physical ones first, then those of the message itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Check {
    /// Joint position limits.
    Limits = 0,
    /// A stance foot leaves its declared pose, or the world does not support its sole.
    Contact = 1,
    /// No contact forces balance the robot, or its centre of mass leaves the support polygon.
    Balance = 2,
    /// The robot collides with the world.
    Collision = 3,
    /// The robot collides with itself.
    SelfCollision = 4,
    /// A joint torque or force exceeds its limit.
    Torque = 5,
    /// Waypoints are too far apart, or their time does not increase.
    Spacing = 6,
    /// The chunk does not continue the one before.
    Continuity = 7,
    /// The schema is unknown, a count is out of range, a number is not finite, a quaternion is not
    /// a unit quaternion, or the contacts do not fit the mode.
    Malformed = 8,
    /// The CRC does not match the bytes.
    Crc = 9,
    /// The stream digest does not continue the accepted stream.
    Stream = 10,
    /// The sequence number is not the next one.
    Sequence = 11,
    /// The chunk is for another robot.
    Robot = 12,
    /// The chunk is for another world.
    World = 13,
    /// The chunk is for another scenario.
    Config = 14,
    /// The chunk is for another controller.
    Controller = 15,
    /// The actual world differs from the planner's; [`Feedback::corrections`] holds the
    /// differences.
    WorldDiffers = 16,
    /// The feet are not at their planned poses, and the plan cannot continue from there;
    /// [`Feedback::rest_state`] holds the configuration.
    FootMisplaced = 17,
    /// A joint's acceleration exceeds its limit.
    Acceleration = 18,
    /// The contacts cannot hold the moving robot: its zero-moment point leaves their region.
    ZeroMoment = 19,
    /// A joint torque or force of the moving robot exceeds its limit, or no contact forces move it
    /// so.
    DynamicTorque = 20,
}

impl Check {
    /// All checks, in wire order.
    pub const ALL: [Self; 21] = [
        Self::Limits,
        Self::Contact,
        Self::Balance,
        Self::Collision,
        Self::SelfCollision,
        Self::Torque,
        Self::Spacing,
        Self::Continuity,
        Self::Malformed,
        Self::Crc,
        Self::Stream,
        Self::Sequence,
        Self::Robot,
        Self::World,
        Self::Config,
        Self::Controller,
        Self::WorldDiffers,
        Self::FootMisplaced,
        Self::Acceleration,
        Self::ZeroMoment,
        Self::DynamicTorque,
    ];

    /// The check with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        Self::ALL.get(value as usize).copied()
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        [
            "limits",
            "contact",
            "balance",
            "collision",
            "self_collision",
            "torque",
            "spacing",
            "continuity",
            "malformed",
            "crc",
            "stream",
            "sequence",
            "robot",
            "world",
            "config",
            "controller",
            "world_differs",
            "foot_misplaced",
            "acceleration",
            "zero_moment",
            "dynamic_torque",
        ][self as usize]
    }
}

/// The decision on the last chunk that the controller checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Verdict {
    /// No chunk has been checked.
    Waiting = 0,
    /// The chunk is accepted and executed.
    Accepted = 1,
    /// The chunk is refused; the robot stands at the end of the chunk before.
    Refused = 2,
}

/// The smallest margins so far, one for each physical check. A negative margin is a violation.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Margins.v2")]
pub struct Margins {
    /// Distance of a joint from its position limits, rad or m.
    pub limits: f64,
    /// Position tolerance of a stance foot minus its position error, m.
    pub contact: f64,
    /// Distance of the centre of mass from the edge of the equilibrium region, m.
    pub balance: f64,
    /// Distance between the robot and the world, stance soles excepted, m, at most 0.1; negative if
    /// they overlap.
    pub collision: f64,
    /// Distance between links that may collide, m, at most 0.1; negative if they overlap.
    pub self_collision: f64,
    /// Unused share of a joint's effort limit.
    pub torque: f64,
    /// Distance of the zero-moment point from the edge of the equilibrium region, m.
    pub zero_moment: f64,
    /// Unused share of a joint's effort limit by inverse dynamics.
    pub dynamic_torque: f64,
}

impl Margins {
    /// Before the first measurement: every margin is infinite.
    pub const UNMEASURED: Self = Self {
        limits: f64::INFINITY,
        contact: f64::INFINITY,
        balance: f64::INFINITY,
        collision: f64::INFINITY,
        self_collision: f64::INFINITY,
        torque: f64::INFINITY,
        zero_moment: f64::INFINITY,
        dynamic_torque: f64::INFINITY,
    };

    /// The smaller margin of each check.
    pub fn min(&self, other: &Self) -> Self {
        Self {
            limits: self.limits.min(other.limits),
            contact: self.contact.min(other.contact),
            balance: self.balance.min(other.balance),
            collision: self.collision.min(other.collision),
            self_collision: self.self_collision.min(other.self_collision),
            torque: self.torque.min(other.torque),
            zero_moment: self.zero_moment.min(other.zero_moment),
            dynamic_torque: self.dynamic_torque.min(other.dynamic_torque),
        }
    }
}

/// The controller's feedback, a cumulative acknowledgement: every chunk before `next_sequence` is
/// accepted. It is repeated as a heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Feedback.v1")]
pub struct Feedback {
    /// [`FEEDBACK_SCHEMA`].
    pub schema: u64,
    /// The controller's id: random, never 0.
    pub controller_id: u64,
    /// The planner's session; 0 before the first chunk.
    pub session: u64,
    /// The plan that the controller executes.
    pub plan_id: u64,
    /// The epoch that the controller executes.
    pub epoch: u64,
    /// The sequence number of the next chunk; all chunks before it are accepted.
    pub next_sequence: u64,
    /// Number of this feedback message of the controller.
    pub count: u64,
    /// A [`Verdict`] as its wire value. A refusal stays until the planner sends a new epoch.
    pub verdict: u32,
    /// The violated [`Check`] as its wire value, of a refusal.
    pub check: u32,
    /// The sequence number of the refused chunk, of a refusal.
    pub refused_sequence: u64,
    /// The index of the waypoint that violates the check, of a refusal.
    pub refused_waypoint: u32,
    /// 1 once the last chunk of the plan is accepted.
    pub finished: u32,
    /// Accepted chunks that were received again, and not executed again, since the controller's
    /// start.
    pub duplicated: u64,
    /// Chunks that were received before their predecessors, and ignored, since the controller's
    /// start.
    pub gaps: u64,
    /// Chunks that the robot executed since it was set on its start, under all controllers. If a
    /// chunk is executed twice, it exceeds the number of accepted chunks.
    pub walked: u64,
    /// How often the robot had to stop because the next chunk was not there, under all controllers.
    pub brakes: u64,
    /// How long it stood for that reason, s of its own time.
    pub stood: f64,
    /// 1 while a chunk is being checked, or walked before its acknowledgement. Such a heartbeat
    /// shows only that the controller runs.
    pub busy: u32,
    /// Number of used entries of `corrections`.
    pub corrections_len: u32,
    /// 1 while the robot moves; it comes to rest at `rest_state` if no further chunk is accepted.
    pub moving: u32,
    /// CRC-32 (IEEE) of all bytes of the message with this field zero.
    pub crc: u32,
    /// Digest of the stream of all accepted chunks; undefined while `next_sequence` is 0.
    pub stream: Digest,
    /// Smallest margins of the accepted chunks.
    pub margins: Margins,
    /// The robot's rest state.
    pub rest_state: RestState,
    /// All differences from the world file that were encountered so far, oldest first. None is
    /// removed.
    pub corrections: [WorldCorrection; CORRECTIONS_MAX],
}

const _: () = assert!(size_of::<Margins>() == 64);
const _: () = assert!(
    size_of::<Feedback>()
        == 232 + size_of::<RestState>() + CORRECTIONS_MAX * size_of::<WorldCorrection>()
);

impl Verdict {
    /// The verdict with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        [Self::Waiting, Self::Accepted, Self::Refused]
            .into_iter()
            .find(|verdict| *verdict as u32 == value)
    }
}

impl WithCrc for Feedback {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl Feedback {
    /// The used entries of `corrections`.
    pub fn corrections(&self) -> &[WorldCorrection] {
        &self.corrections[..(self.corrections_len as usize).min(CORRECTIONS_MAX)]
    }

    /// Whether the message is undamaged, its schema and wire values are valid and its numbers are
    /// in range.
    pub fn is_well_formed(&self) -> bool {
        let verdict = Verdict::from_wire(self.verdict);
        let has_valid_refusal =
            verdict != Some(Verdict::Refused) || Check::from_wire(self.check).is_some();
        self.schema == FEEDBACK_SCHEMA
            && self.controller_id != 0
            && verdict.is_some()
            && has_valid_refusal
            && self.finished <= 1
            && self.busy <= 1
            && self.moving <= 1
            && self.stood.is_finite()
            && self.corrections_len as usize <= CORRECTIONS_MAX
            && self.crc_matches()
            && self.corrections().iter().all(WorldCorrection::is_well_formed)
            && self.rest_state.is_well_formed()
    }
}

layout!(Margins {
    limits: f64,
    contact: f64,
    balance: f64,
    collision: f64,
    self_collision: f64,
    torque: f64,
    zero_moment: f64,
    dynamic_torque: f64,
} with []);
layout!(Feedback {
    schema: u64,
    controller_id: u64,
    session: u64,
    plan_id: u64,
    epoch: u64,
    next_sequence: u64,
    count: u64,
    verdict: u32,
    check: u32,
    refused_sequence: u64,
    refused_waypoint: u32,
    finished: u32,
    duplicated: u64,
    gaps: u64,
    walked: u64,
    brakes: u64,
    stood: f64,
    busy: u32,
    corrections_len: u32,
    moving: u32,
    crc: u32,
    stream: Digest,
    margins: Margins,
    rest_state: RestState,
    corrections: [WorldCorrection; CORRECTIONS_MAX],
} with [Margins, RestState, WorldCorrection]);

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn every_check_has_its_wire_value() {
        for check in Check::ALL {
            assert_eq!(Check::from_wire(check as u32), Some(check));
            assert!(!check.name().is_empty());
        }
        assert_eq!(Check::from_wire(Check::ALL.len() as u32), None);
        assert_eq!(Verdict::from_wire(2), Some(Verdict::Refused));
        assert_eq!(Verdict::from_wire(3), None);
    }

    #[test]
    fn malformed_feedback_is_recognized() {
        let with_crc = |feedback: &Feedback| {
            let mut with_crc = *feedback;
            with_crc.write_crc();
            with_crc
        };
        let good = Feedback {
            schema: FEEDBACK_SCHEMA,
            controller_id: 7,
            verdict: 2,
            check: 9,
            ..Feedback::zeroed()
        };
        assert!(!good.is_well_formed(), "without a CRC");
        assert!(with_crc(&good).is_well_formed());
        let bad = [
            Feedback { schema: 1, ..good },
            Feedback { controller_id: 0, ..good },
            Feedback { verdict: 3, ..good },
            Feedback { check: Check::ALL.len() as u32, ..good },
            Feedback { finished: 2, ..good },
            Feedback { busy: 2, ..good },
            Feedback { moving: 2, ..good },
            Feedback { stood: f64::NAN, ..good },
            Feedback { corrections_len: CORRECTIONS_MAX as u32 + 1, ..good },
            Feedback {
                corrections_len: 1,
                corrections: [WorldCorrection { kind: 9, ..good.corrections[0] }; CORRECTIONS_MAX],
                ..good
            },
            Feedback { rest_state: RestState { contacts_len: 9, ..good.rest_state }, ..good },
        ];
        assert!(bad.iter().all(|feedback| !with_crc(feedback).is_well_formed()));
    }
}
