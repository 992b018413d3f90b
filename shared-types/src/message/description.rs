//! What a reader has to know of a walk beside its messages: the names and the order of the joints,
//! their units and limits, the soles, and the digests of robot, world and scenario.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::Digest;
use crate::base::limits::{CONTACTS_MAX, JOINTS_MAX, NAME_BYTES_MAX, POLYGON_VERTICES_MAX};
use crate::message::chunk::is_rotation;
use crate::message::crc::WithCrc;
use crate::message::layout::layout;

/// The layout version in [`Description::schema`].
pub const DESCRIPTION_SCHEMA: u64 = 1;

/// The frame of all poses in messages, and the orders and units of their numbers.
pub const CONVENTIONS: &str =
    "frame world, z up; quaternion x y z w; m rad s kg N N*m; joints depth first from the root";

/// Most bytes of [`CONVENTIONS`].
const CONVENTIONS_BYTES: usize = 128;

const _: () = assert!(CONVENTIONS.len() <= CONVENTIONS_BYTES);

/// A text in UTF-8.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Name.v1")]
pub struct Name {
    /// Number of its bytes; more than `bytes` holds if it is cut.
    pub length: u64,
    /// The bytes, with zeros after them.
    pub bytes: [u8; NAME_BYTES_MAX],
}

/// A moving joint.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.JointDescription.v1")]
pub struct JointDescription {
    /// Its name in the URDF.
    pub name: Name,
    /// 0: it turns (rad, N m); 1: it slides (m, N).
    pub kind: u64,
    /// Lower position limit, rad or m.
    pub lower: f64,
    /// Upper position limit, rad or m.
    pub upper: f64,
    /// Largest speed, rad/s or m/s.
    pub velocity: f64,
    /// Largest acceleration, rad/s2 or m/s2.
    pub acceleration: f64,
    /// Largest effort, N m or N.
    pub effort: f64,
}

/// A foot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.FootDescription.v1")]
pub struct FootDescription {
    /// "left" or "right".
    pub name: Name,
    /// The link that carries the sole.
    pub link: Name,
    /// Position of the sole frame in the link's frame, m. Its z points into the foot, x forward.
    pub position: [f64; 3],
    /// Rotation of the sole frame in the link's frame, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// Number of used entries of `polygon`.
    pub polygon_len: u64,
    /// The sole's outline in the sole frame: convex, counter-clockwise, m.
    pub polygon: [[f64; 2]; POLYGON_VERTICES_MAX],
}

/// What a reader has to know of a walk. Planner and controller each publish it; a late reader
/// receives it too. With it no reader needs a file.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.Description.v1")]
pub struct Description {
    /// [`DESCRIPTION_SCHEMA`].
    pub schema: u64,
    /// The planner's session or the controller's id.
    pub sender: u64,
    /// Number of used entries of `joints`.
    pub joints_len: u32,
    /// Number of used entries of `feet`.
    pub feet_len: u32,
    /// Zero.
    pub reserved: u32,
    /// CRC-32 (IEEE) of all bytes of the message with this field zero.
    pub crc: u32,
    /// Digest of the robot.
    pub robot: Digest,
    /// Digest of the world as the sender knew it at its start.
    pub world: Digest,
    /// Digest of the scenario.
    pub config: Digest,
    /// Frame, orders and units of the numbers in all messages, as a sentence.
    pub conventions: [u8; CONVENTIONS_BYTES],
    /// The robot's name in the URDF.
    pub robot_name: Name,
    /// The link whose pose the messages call that of the root.
    pub root_link: Name,
    /// Total mass, kg.
    pub mass: f64,
    /// The moving joints in the order of all joint vectors.
    pub joints: [JointDescription; JOINTS_MAX],
    /// The feet; contacts and forces name them by their index.
    pub feet: [FootDescription; CONTACTS_MAX],
}

const _: () = assert!(size_of::<Name>() == 8 + NAME_BYTES_MAX);
const _: () = assert!(size_of::<JointDescription>() == size_of::<Name>() + 48);
const _: () =
    assert!(size_of::<FootDescription>() == 2 * size_of::<Name>() + 64 + 16 * POLYGON_VERTICES_MAX);

layout!(Name { length: u64, bytes: [u8; NAME_BYTES_MAX] } with []);
layout!(JointDescription {
    name: Name,
    kind: u64,
    lower: f64,
    upper: f64,
    velocity: f64,
    acceleration: f64,
    effort: f64,
} with [Name]);
layout!(FootDescription {
    name: Name,
    link: Name,
    position: [f64; 3],
    rotation: [f64; 4],
    polygon_len: u64,
    polygon: [[f64; 2]; POLYGON_VERTICES_MAX],
} with [Name]);
layout!(Description {
    schema: u64,
    sender: u64,
    joints_len: u32,
    feet_len: u32,
    reserved: u32,
    crc: u32,
    robot: Digest,
    world: Digest,
    config: Digest,
    conventions: [u8; 128],
    robot_name: Name,
    root_link: Name,
    mass: f64,
    joints: [JointDescription; JOINTS_MAX],
    feet: [FootDescription; CONTACTS_MAX],
} with [Name, JointDescription, FootDescription]);

impl WithCrc for Description {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        let mut name = Self { length: text.len() as u64, ..Self::zeroed() };
        let used = text.len().min(NAME_BYTES_MAX);
        name.bytes[..used].copy_from_slice(&text.as_bytes()[..used]);
        name
    }
}

impl Name {
    /// The text; `None` if it is cut or not UTF-8.
    pub fn text(&self) -> Option<&str> {
        let used = usize::try_from(self.length).ok().filter(|used| *used <= NAME_BYTES_MAX)?;
        std::str::from_utf8(&self.bytes[..used]).ok()
    }
}

impl Description {
    /// The used entries of `joints`.
    pub fn joints(&self) -> &[JointDescription] {
        &self.joints[..(self.joints_len as usize).min(JOINTS_MAX)]
    }

    /// The used entries of `feet`.
    pub fn feet(&self) -> &[FootDescription] {
        &self.feet[..(self.feet_len as usize).min(CONTACTS_MAX)]
    }

    /// Whether schema, CRC and counts are valid, all numbers are finite and all rotations are.
    pub fn is_well_formed(&self) -> bool {
        let joint = |joint: &JointDescription| {
            let JointDescription { lower, upper, velocity, acceleration, effort, .. } = *joint;
            joint.kind <= 1
                && [lower, upper, velocity, acceleration, effort].map(f64::is_finite) == [true; 5]
        };
        let foot = |foot: &FootDescription| {
            foot.polygon_len as usize <= POLYGON_VERTICES_MAX
                && foot
                    .position
                    .into_iter()
                    .chain(foot.polygon.into_iter().flatten())
                    .all(f64::is_finite)
                && is_rotation(foot.rotation)
        };
        self.schema == DESCRIPTION_SCHEMA
            && self.sender != 0
            && self.crc_matches()
            && self.joints_len as usize <= JOINTS_MAX
            && self.feet_len as usize <= CONTACTS_MAX
            && self.mass.is_finite()
            && self.joints().iter().all(joint)
            && self.feet().iter().all(foot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_does_not_fit_is_known_as_cut() {
        let name = Name::from("left_knee");
        assert_eq!((name.text(), name.length), (Some("left_knee"), 9));
        let long = "k".repeat(NAME_BYTES_MAX + 1);
        let cut = Name::from(long.as_str());
        assert_eq!((cut.text(), cut.length), (None, NAME_BYTES_MAX as u64 + 1));
    }

    #[test]
    fn a_description_with_another_crc_or_count_is_refused() {
        let mut description = Description {
            schema: DESCRIPTION_SCHEMA,
            sender: 5,
            joints_len: 1,
            ..Description::zeroed()
        };
        description.write_crc();
        assert!(description.is_well_formed());
        let refused = |change: &dyn Fn(&mut Description), rewrites: bool| {
            let mut other = description;
            change(&mut other);
            if rewrites {
                other.write_crc();
            }
            assert!(!other.is_well_formed());
        };
        refused(&|other| other.mass = 1.0, false);
        refused(&|other| other.joints_len = JOINTS_MAX as u32 + 1, true);
        refused(&|other| other.joints[0].upper = f64::NAN, true);
        refused(&|other| other.joints[0].kind = 2, true);
        refused(&|other| (other.feet_len, other.feet[0].rotation) = (1, [0.0; 4]), true);
        refused(&|other| other.sender = 0, true);
    }
}
