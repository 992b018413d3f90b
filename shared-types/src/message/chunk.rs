//! Plan chunks: a plan is sent as a stream of chunks, each within one support mode.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::{Digest, Link};
use crate::base::limits::{
    CHUNK_BINDINGS_MAX, CHUNK_WAYPOINTS_MAX, CONTACTS_MAX, JOINTS_MAX, POLYGON_VERTICES_MAX,
};
use crate::base::spatial::Pose;
use crate::message::binding::ChunkBinding;
use crate::message::crc::WithCrc;
use crate::message::layout::layout;
use crate::message::request::StancePoseData;

/// Largest excess of the instant at which the robot stands over the chunk's end, s: times are
/// rounded.
pub const STOP_ROUNDING_MAX: f64 = 1e-9;
/// The longest time in which a robot brakes or goes on, s.
pub const RAMP_SECONDS_MAX: f64 = 20.0;
/// The layout version in [`PlanChunk::schema`].
pub const CHUNK_SCHEMA: u64 = 3;
/// Flag: the first chunk of its plan.
pub const FLAG_FIRST: u32 = 1;
/// Flag: the last chunk of its plan.
pub const FLAG_LAST: u32 = 2;

/// The freedoms of the root: position and rotation.
pub const ROOT_FREEDOMS: usize = 6;

/// A configuration of the robot with its time, velocity, acceleration and torques.
/// [`Interpolation`] says how the robot moves between two waypoints, [`PlanTime::apply`] what it
/// does where plan time passes at another rate than 1.
///
/// [`Interpolation`]: crate::message::Interpolation
/// [`PlanTime::apply`]: crate::message::PlanTime::apply
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Waypoint.v3")]
pub struct Waypoint {
    /// Time since the start of the plan, s; strictly increasing.
    pub time: f64,
    /// Root position in the world, m.
    pub root_position: [f64; 3],
    /// Root rotation in the world, unit quaternion x, y, z, w.
    pub root_rotation: [f64; 4],
    /// Joint positions in the order of `RobotModel::joints`, rad or m; unused entries are 0.
    pub q: [f64; JOINTS_MAX],
    /// Velocity of the root's origin (m/s), then the root's angular velocity (rad/s), both along
    /// the world's axes.
    pub root_velocity: [f64; ROOT_FREEDOMS],
    /// Joint velocities, rad/s or m/s; unused entries are 0.
    pub joint_velocity: [f64; JOINTS_MAX],
    /// The derivative of `root_velocity`, m/s2 and rad/s2.
    pub root_acceleration: [f64; ROOT_FREEDOMS],
    /// Joint accelerations, rad/s2 or m/s2; unused entries are 0.
    pub joint_acceleration: [f64; JOINTS_MAX],
    /// Feed-forward joint efforts, N m or N, linear between waypoints; 0 where the plan states
    /// none.
    pub torque: [f64; JOINTS_MAX],
    /// The same if the robot rests in this configuration.
    pub rest_torque: [f64; JOINTS_MAX],
    /// By how much feed-forward changes where the rate of plan time changes by 1 a second, N m s
    /// or N s.
    pub rate_change_torque: [f64; JOINTS_MAX],
}

impl Waypoint {
    /// A waypoint at rest, without feed-forward.
    pub fn at_rest(time: f64, world_from_root: &Pose, q: &[f64; JOINTS_MAX]) -> Self {
        Self {
            time,
            root_position: world_from_root.translation.to_array(),
            root_rotation: world_from_root.rotation.to_array(),
            q: *q,
            ..Self::zeroed()
        }
    }

    /// The same time and configuration at rest, without feed-forward.
    #[must_use]
    pub fn rested(&self) -> Self {
        Self {
            time: self.time,
            root_position: self.root_position,
            root_rotation: self.root_rotation,
            q: self.q,
            ..Self::zeroed()
        }
    }

    /// The pose of the root in the world.
    pub fn world_from_root(&self) -> Pose {
        pose_from_parts(self.root_position, self.root_rotation)
    }

    /// Velocity, acceleration and torques, one number after the other.
    pub fn rates(&self) -> impl Iterator<Item = f64> + use<> {
        let root = self.root_velocity.into_iter().chain(self.root_acceleration);
        let joints = self.joint_velocity.into_iter().chain(self.joint_acceleration);
        let torques = self.torque.into_iter().chain(self.rest_torque);
        root.chain(joints).chain(torques).chain(self.rate_change_torque)
    }

    /// Adds time and configuration to a digest, and velocity, acceleration and torques unless all
    /// of them are 0.
    fn add_to(&self, link: &mut Link, joints: usize) {
        link.add(&[self.time]);
        link.add(&self.root_position);
        link.add(&self.root_rotation);
        link.add(&self.q[..joints]);
        let has_rates = self.rates().any(|rate| rate.to_bits() != 0);
        link.add(&[u8::from(has_rates)]);
        if has_rates {
            link.add(&self.root_velocity);
            link.add(&self.joint_velocity[..joints]);
            link.add(&self.root_acceleration);
            link.add(&self.joint_acceleration[..joints]);
            link.add(&self.torque[..joints]);
            link.add(&self.rest_torque[..joints]);
            link.add(&self.rate_change_torque[..joints]);
        }
    }
}

/// A contact of a stance foot during a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Contact.v1")]
pub struct Contact {
    /// Index of the foot in `RobotModel::feet`.
    pub limb: u32,
    /// Number of used entries of `polygon`.
    pub polygon_len: u32,
    /// Sole position in the world, m.
    pub position: [f64; 3],
    /// Sole rotation in the world, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// The supported part of the sole according to the planner: a convex polygon,
    /// counter-clockwise, in the sole frame, m.
    pub polygon: [[f64; 2]; POLYGON_VERTICES_MAX],
}

impl Contact {
    /// The used entries of `polygon`.
    pub fn polygon(&self) -> &[[f64; 2]] {
        &self.polygon[..(self.polygon_len as usize).min(POLYGON_VERTICES_MAX)]
    }

    /// The pose of the sole in the world.
    pub fn world_from_sole(&self) -> Pose {
        pose_from_parts(self.position, self.rotation)
    }
}

/// The support mode: the feet that carry the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SupportMode {
    /// The left foot alone.
    Left = 0,
    /// The right foot alone.
    Right = 1,
    /// Both feet.
    Double = 2,
}

impl SupportMode {
    /// The mode with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        [Self::Left, Self::Right, Self::Double].into_iter().find(|mode| *mode as u32 == value)
    }

    /// The mode with this name in the plan format, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Left, Self::Right, Self::Double].into_iter().find(|mode| mode.name() == name)
    }

    /// Its name in the plan format.
    pub fn name(self) -> &'static str {
        ["left", "right", "double"][self as usize]
    }

    /// Whether a limb carries the robot in this mode. Only limbs 0 (left) and 1 (right) do.
    pub fn carries(self, limb: usize) -> bool {
        match self {
            Self::Left => limb == 0,
            Self::Right => limb == 1,
            Self::Double => limb < 2,
        }
    }
}

/// A part of a plan within one support mode. Its first waypoint repeats the last one of the chunk
/// before. Every waypoint is statically stable. The robot may stop along the chunk's path.
///
/// The controller walks plan time at a rate: normally 1 s of the plan each second. If the next
/// chunk is not accepted when plan time reaches `brake_at`, the rate falls to 0 over
/// `brake_duration`, and the robot stands half of `brake_duration` of plan time later, within the
/// chunk. If the next chunk comes after that, the rate rises to 1 over `resume_duration`, across
/// the chunk's end if need be ([`Ramp`](crate::message::Ramp)).
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.PlanChunk.v3")]
pub struct PlanChunk {
    /// [`CHUNK_SCHEMA`].
    pub schema: u64,
    /// The planner's session, a random id.
    pub session: u64,
    /// The id of the controller that the chunk is for.
    pub target_controller: u64,
    /// Number of the plan in its session.
    pub plan_id: u64,
    /// Number of the replan within the plan.
    pub epoch: u64,
    /// Number of the chunk in its epoch, from 0.
    pub sequence: u64,
    /// [`FLAG_FIRST`], [`FLAG_LAST`].
    pub flags: u32,
    /// A [`SupportMode`] as its wire value.
    pub mode: u32,
    /// Number of used entries of `contacts`.
    pub contacts_len: u32,
    /// Number of used entries of `waypoints`: at least 2, or 1 if the chunk only repeats a
    /// transition.
    pub waypoints_len: u32,
    /// Number of used entries of `q` in every waypoint.
    pub joints_len: u32,
    /// CRC-32 (IEEE) of all bytes of the chunk with this field zero.
    pub crc: u32,
    /// The [`Interpolation`](crate::message::Interpolation) between waypoints, as
    /// its wire value.
    pub interpolation: u64,
    /// The plan time at which the robot brakes if the next chunk is not accepted, s; not before
    /// that of the chunk before, but maybe before the chunk's first waypoint. The time of the last
    /// waypoint if the chunk ends at rest.
    pub brake_at: f64,
    /// How long the robot brakes, s; 0 if the chunk ends at rest.
    pub brake_duration: f64,
    /// How long the robot takes to full speed after it has braked in this chunk, s.
    pub resume_duration: f64,
    /// Digest of the robot.
    pub robot: Digest,
    /// Digest of the world.
    pub world: Digest,
    /// Digest of the scenario.
    pub config: Digest,
    /// Digest of the stream before this chunk.
    pub stream: Digest,
    /// The contacts of the stance feet.
    pub contacts: [Contact; CONTACTS_MAX],
    /// The motion.
    pub waypoints: [Waypoint; CHUNK_WAYPOINTS_MAX],
    /// The goal that the plan was asked for; of width 0 where the sender states none. It is no part
    /// of the stream's digest, since the plan does not depend on who asked for it.
    pub goal: StancePoseData,
    /// The limits that bind the motion of the chunk, the longest first, as the planner timed it;
    /// all unused where it was not timed within limits. They are no part of the stream's digest,
    /// since they explain the motion and do not change it.
    pub binding: [ChunkBinding; CHUNK_BINDINGS_MAX],
}

const _: () = assert!(size_of::<Waypoint>() == 64 + 16 * ROOT_FREEDOMS + 48 * JOINTS_MAX);
const _: () = assert!(size_of::<Contact>() == 64 + 16 * POLYGON_VERTICES_MAX);
const _: () = assert!(
    size_of::<PlanChunk>()
        == 232
            + CONTACTS_MAX * size_of::<Contact>()
            + CHUNK_WAYPOINTS_MAX * size_of::<Waypoint>()
            + size_of::<StancePoseData>()
            + CHUNK_BINDINGS_MAX * size_of::<ChunkBinding>()
);

layout!(Waypoint {
    time: f64,
    root_position: [f64; 3],
    root_rotation: [f64; 4],
    q: [f64; JOINTS_MAX],
    root_velocity: [f64; ROOT_FREEDOMS],
    joint_velocity: [f64; JOINTS_MAX],
    root_acceleration: [f64; ROOT_FREEDOMS],
    joint_acceleration: [f64; JOINTS_MAX],
    torque: [f64; JOINTS_MAX],
    rest_torque: [f64; JOINTS_MAX],
    rate_change_torque: [f64; JOINTS_MAX],
} with []);
layout!(Contact {
    limb: u32,
    polygon_len: u32,
    position: [f64; 3],
    rotation: [f64; 4],
    polygon: [[f64; 2]; POLYGON_VERTICES_MAX],
} with []);
layout!(PlanChunk {
    schema: u64,
    session: u64,
    target_controller: u64,
    plan_id: u64,
    epoch: u64,
    sequence: u64,
    flags: u32,
    mode: u32,
    contacts_len: u32,
    waypoints_len: u32,
    joints_len: u32,
    crc: u32,
    interpolation: u64,
    brake_at: f64,
    brake_duration: f64,
    resume_duration: f64,
    robot: Digest,
    world: Digest,
    config: Digest,
    stream: Digest,
    contacts: [Contact; CONTACTS_MAX],
    waypoints: [Waypoint; CHUNK_WAYPOINTS_MAX],
    goal: StancePoseData,
    binding: [ChunkBinding; CHUNK_BINDINGS_MAX],
} with [Contact, Waypoint, StancePoseData, ChunkBinding]);

// SAFETY: a transparent array of bytes without pointers.
unsafe impl ZeroCopySend for Digest {}

impl WithCrc for PlanChunk {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl PlanChunk {
    const SESSION_AT: usize = std::mem::offset_of!(Self, session);
    const TARGET_AT: usize = std::mem::offset_of!(Self, target_controller);

    /// The used entries of `waypoints`.
    pub fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints[..(self.waypoints_len as usize).min(CHUNK_WAYPOINTS_MAX)]
    }

    /// The used entries of `contacts`.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts[..(self.contacts_len as usize).min(CONTACTS_MAX)]
    }

    /// The digest of the stream after this chunk: of all entries that are used. The fields of
    /// sender and receiver (session, target controller, CRC) do not count: a plan has the same
    /// digest in every session.
    pub fn stream_after(&self) -> Digest {
        let bytes = bytemuck::bytes_of(self);
        let mut head = [0; std::mem::offset_of!(Self, contacts)];
        head.copy_from_slice(&bytes[..std::mem::offset_of!(Self, contacts)]);
        let sender_fields = [(Self::SESSION_AT, 8), (Self::TARGET_AT, 8), (Self::CRC_AT, 4)];
        sender_fields.iter().for_each(|&(at, size)| head[at..at + size].fill(0));
        let joints = (self.joints_len as usize).min(JOINTS_MAX);
        self.stream.chain_parts(|link| {
            link.add(&head);
            link.add(self.contacts());
            self.waypoints().iter().for_each(|waypoint| waypoint.add_to(link, joints));
        })
    }
}

/// Largest difference of a unit quaternion's length from 1.
const UNIT_ERROR_MAX: f64 = 1e-6;

/// Whether a quaternion x, y, z, w has unit length.
pub(crate) fn is_rotation(quaternion: [f64; 4]) -> bool {
    (glam::DQuat::from_array(quaternion).length() - 1.0).abs() <= UNIT_ERROR_MAX
}

fn pose_from_parts(position: [f64; 3], rotation: [f64; 4]) -> Pose {
    Pose::from_parts(position.into(), glam::DQuat::from_array(rotation))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    fn with_crc() -> Box<PlanChunk> {
        let mut chunk = Box::new(PlanChunk::zeroed());
        bytemuck::bytes_of_mut(&mut *chunk)
            .iter_mut()
            .enumerate()
            .for_each(|(at, byte)| *byte = (at % 251) as u8);
        chunk.write_crc();
        chunk
    }

    #[test]
    fn only_limbs_0_and_1_carry() {
        let carriers =
            |mode: SupportMode| (0..9).filter(|&limb| mode.carries(limb)).collect::<Vec<_>>();
        let modes = [SupportMode::Left, SupportMode::Right, SupportMode::Double];
        assert_eq!(modes.map(carriers), [vec![0], vec![1], vec![0, 1]]);
    }

    #[test]
    fn every_flipped_bit_of_the_header_breaks_the_crc() {
        let mut chunk = with_crc();
        assert!(chunk.crc_matches());
        for bit in 0..8 * std::mem::offset_of!(PlanChunk, contacts) {
            bytemuck::bytes_of_mut(&mut *chunk)[bit / 8] ^= 1 << (bit % 8);
            assert!(!chunk.crc_matches(), "header bit {bit}");
            bytemuck::bytes_of_mut(&mut *chunk)[bit / 8] ^= 1 << (bit % 8);
        }
        assert!(chunk.crc_matches());
    }

    #[test]
    fn every_flipped_byte_breaks_the_crc() {
        let mut chunk = with_crc();
        for at in 0..size_of::<PlanChunk>() {
            bytemuck::bytes_of_mut(&mut *chunk)[at] ^= 0xff;
            assert!(!chunk.crc_matches(), "byte {at}");
            bytemuck::bytes_of_mut(&mut *chunk)[at] ^= 0xff;
        }
    }

    #[test]
    fn the_stream_digest_ignores_the_sender() {
        let chunk = with_crc();
        let mut other = chunk.clone();
        (other.session, other.target_controller) = (1, 2);
        other.write_crc();
        assert_eq!(other.stream_after(), chunk.stream_after());
        other.waypoints[3].q[4] = 0.5;
        assert_ne!(other.stream_after(), chunk.stream_after());
    }

    #[test]
    fn the_stream_digest_depends_on_all_that_is_used_and_on_nothing_else() {
        let mut chunk = Box::new(PlanChunk::zeroed());
        (chunk.contacts_len, chunk.waypoints_len, chunk.joints_len) = (1, 2, 3);
        let at_rest = chunk.stream_after();
        chunk.waypoints[1].torque[2] = 1.0;
        let moving = chunk.stream_after();
        assert_ne!(at_rest, moving);
        let differs = |change: &dyn Fn(&mut PlanChunk)| {
            let mut other = chunk.clone();
            change(&mut other);
            other.stream_after() != moving
        };
        let used: [&dyn Fn(&mut PlanChunk); 14] = [
            &|chunk| chunk.sequence = 1,
            &|chunk| chunk.brake_at = 1.0,
            &|chunk| chunk.contacts[0].polygon[5][1] = 1.0,
            &|chunk| chunk.waypoints[0].time = 1.0,
            &|chunk| chunk.waypoints[1].root_rotation[3] = 1.0,
            &|chunk| chunk.waypoints[1].q[2] = 1.0,
            &|chunk| chunk.waypoints[0].root_velocity[5] = 1.0,
            &|chunk| chunk.waypoints[1].root_velocity[5] = 1.0,
            &|chunk| chunk.waypoints[1].joint_velocity[2] = 1.0,
            &|chunk| chunk.waypoints[1].root_acceleration[0] = 1.0,
            &|chunk| chunk.waypoints[1].joint_acceleration[2] = 1.0,
            &|chunk| chunk.waypoints[1].torque[0] = 1.0,
            &|chunk| chunk.waypoints[1].rest_torque[2] = 1.0,
            &|chunk| chunk.waypoints[1].rate_change_torque[2] = 1.0,
        ];
        for (index, change) in used.into_iter().enumerate() {
            assert!(differs(change), "used {index}");
        }
        let unused: [&dyn Fn(&mut PlanChunk); 5] = [
            &|chunk| chunk.goal.yaw = 1.0,
            &|chunk| chunk.binding[0].seconds = 1.0,
            &|chunk| chunk.contacts[1].limb = 1,
            &|chunk| chunk.waypoints[2].time = 1.0,
            &|chunk| chunk.waypoints[1].q[3] = 1.0,
        ];
        for (index, change) in unused.into_iter().enumerate() {
            assert!(!differs(change), "unused {index}");
        }
    }
}
