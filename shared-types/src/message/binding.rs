//! Which limits bind a timed motion, and for how long.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::message::layout::layout;

/// The kind of a limit that binds a motion: at it, the motion cannot be faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum LimitKind {
    /// No limit binds: at rests, and where the acceleration changes.
    None = 1,
    /// The largest rate of the path's parameter.
    PathRate = 2,
    /// The speed of a joint.
    Speed = 3,
    /// The acceleration of a joint.
    Acceleration = 4,
    /// The torque of a joint.
    Torque = 5,
    /// The centre of pressure inside the soles.
    CentreOfPressure = 6,
    /// The zero-moment point inside the support.
    ZeroMoment = 7,
    /// Friction.
    Friction = 8,
    /// Contact forces and torques together.
    Contacts = 9,
    /// The speed of a landing sole.
    Touchdown = 10,
    /// The speed of a stance sole.
    StanceSole = 11,
}

impl LimitKind {
    /// All kinds, in the order of their wire values.
    const ALL: [Self; 11] = [
        Self::None,
        Self::PathRate,
        Self::Speed,
        Self::Acceleration,
        Self::Torque,
        Self::CentreOfPressure,
        Self::ZeroMoment,
        Self::Friction,
        Self::Contacts,
        Self::Touchdown,
        Self::StanceSole,
    ];

    /// The kind with this wire value, if the value is valid.
    pub fn from_wire(value: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u32 == value)
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::PathRate => "path_rate",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Torque => "torque",
            Self::CentreOfPressure => "centre_of_pressure",
            Self::ZeroMoment => "zero_moment",
            Self::Friction => "friction",
            Self::Contacts => "contact_forces",
            Self::Touchdown => "touchdown_speed",
            Self::StanceSole => "stance_sole_speed",
        }
    }

    /// Whether such a limit concerns one joint.
    pub fn is_of_joint(self) -> bool {
        matches!(self, Self::Speed | Self::Acceleration | Self::Torque)
    }
}

/// How long a limit binds the motion of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.ChunkBinding.v1")]
pub struct ChunkBinding {
    /// A [`LimitKind`] as its wire value; 0 in an unused entry.
    pub kind: u32,
    /// Index of the joint that a limit of a joint concerns; 0 otherwise.
    pub joint: u32,
    /// Time for which it binds, s.
    pub seconds: f64,
}

const _: () = assert!(size_of::<ChunkBinding>() == 16);

layout!(ChunkBinding { kind: u32, joint: u32, seconds: f64 } with []);

impl ChunkBinding {
    /// The entry of a limit.
    pub fn new(kind: LimitKind, joint: Option<usize>, seconds: f64) -> Self {
        Self { kind: kind as u32, joint: joint.unwrap_or(0) as u32, seconds }
    }

    /// The limit, the joint that it concerns, and the time for which it binds (s); `None` for an
    /// unused or a malformed entry.
    pub fn known(&self) -> Option<(LimitKind, Option<usize>, f64)> {
        let kind = LimitKind::from_wire(self.kind)?;
        let joint = kind.is_of_joint().then_some(self.joint as usize);
        (self.seconds > 0.0 && self.seconds.is_finite()).then_some((kind, joint, self.seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_survives_the_wire_and_malformed_entries_are_none() {
        for kind in LimitKind::ALL {
            assert_eq!(LimitKind::from_wire(kind as u32), Some(kind));
            let joint = kind.is_of_joint().then_some(7);
            assert_eq!(
                ChunkBinding::new(kind, joint, 0.5).known(),
                Some((kind, joint, 0.5)),
                "{}",
                kind.name()
            );
        }
        assert_eq!(ChunkBinding::zeroed().known(), None);
        let torque = ChunkBinding::new(LimitKind::Torque, Some(3), 0.25);
        let malformed = [
            ChunkBinding { kind: 12, ..torque },
            ChunkBinding { seconds: f64::NAN, ..torque },
            ChunkBinding { seconds: -1.0, ..torque },
            ChunkBinding { seconds: f64::INFINITY, ..torque },
        ];
        assert!(malformed.iter().all(|entry| entry.known().is_none()));
    }
}
