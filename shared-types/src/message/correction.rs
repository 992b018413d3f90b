//! World corrections: differences between the actual world and the world file that a controller
//! encountered.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::spatial::Pose;
use crate::message::chunk::is_rotation;
use crate::message::layout::layout;

/// [`WorldCorrection::shape`] of a correction that concerns no shape of the world file.
pub const NO_SHAPE: u32 = u32::MAX;
/// Largest coordinate of a correction, m.
const COORDINATE_MAX: f64 = 1e4;

/// The kind of a world correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum CorrectionKind {
    /// The shape has another pose: `position` and `rotation`.
    Moved = 1,
    /// The shape does not exist.
    Missing = 2,
    /// A box exists that is not in the world file: `position`, `rotation` and `half_extents`.
    Extra = 3,
    /// No surface supports the sole planned at `position` and `rotation`. `half_extents` holds half
    /// of the sole's length and width, and 0.
    ContactMissing = 4,
}

/// One difference between the actual world and the world file.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.WorldCorrection.v1")]
pub struct WorldCorrection {
    /// A [`CorrectionKind`] as its wire value.
    pub kind: u32,
    /// Index in `World::shapes` of a moved or missing shape, else [`NO_SHAPE`].
    pub shape: u32,
    /// Position in the world, m; see [`CorrectionKind`].
    pub position: [f64; 3],
    /// Rotation in the world, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// Half of each side length of an extra box or a sole, m; else 0.
    pub half_extents: [f64; 3],
}

const _: () = assert!(size_of::<WorldCorrection>() == 88);

layout!(WorldCorrection {
    kind: u32,
    shape: u32,
    position: [f64; 3],
    rotation: [f64; 4],
    half_extents: [f64; 3],
} with []);

impl CorrectionKind {
    /// The kind with this wire value, if there is one.
    pub fn from_wire(value: u32) -> Option<Self> {
        [Self::Moved, Self::Missing, Self::Extra, Self::ContactMissing]
            .into_iter()
            .find(|kind| *kind as u32 == value)
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moved => "moved",
            Self::Missing => "missing",
            Self::Extra => "extra",
            Self::ContactMissing => "contact_missing",
        }
    }
}

impl WorldCorrection {
    /// Shape `shape` of the world has the pose `world_from_shape`.
    pub fn moved(shape: u32, world_from_shape: &Pose) -> Self {
        Self::new(CorrectionKind::Moved, shape, world_from_shape, [0.0; 3])
    }

    /// Shape `shape` of the world does not exist.
    pub fn missing(shape: u32) -> Self {
        Self::new(CorrectionKind::Missing, shape, &Pose::IDENTITY, [0.0; 3])
    }

    /// A box that is not in the world file has the pose `world_from_box` and these half side
    /// lengths (m).
    pub fn extra(world_from_box: &Pose, half_extents: [f64; 3]) -> Self {
        Self::new(CorrectionKind::Extra, NO_SHAPE, world_from_box, half_extents)
    }

    /// No surface supports a sole of this half length and half width (m) at `world_from_sole`.
    pub fn contact_missing(world_from_sole: &Pose, half_sides: [f64; 2]) -> Self {
        let [length, width] = half_sides;
        Self::new(CorrectionKind::ContactMissing, NO_SHAPE, world_from_sole, [length, width, 0.0])
    }

    /// Its kind, if the wire value is valid.
    pub fn known_kind(&self) -> Option<CorrectionKind> {
        CorrectionKind::from_wire(self.kind)
    }

    /// The pose in the world of the shape, box or sole.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position.into(), glam::DQuat::from_array(self.rotation))
    }

    /// Whether its kind is valid and its numbers fit that kind.
    pub fn is_well_formed(&self) -> bool {
        let bounded = |values: &[f64]| values.iter().all(|value| value.abs() <= COORDINATE_MAX);
        let sides = self.half_extents;
        let sized = match self.known_kind() {
            Some(CorrectionKind::Extra) => sides.iter().all(|side| *side > 0.0),
            Some(CorrectionKind::ContactMissing) => sides[0] > 0.0 && sides[1] > 0.0,
            Some(CorrectionKind::Moved | CorrectionKind::Missing) => self.shape != NO_SHAPE,
            None => false,
        };
        sized && is_rotation(self.rotation) && bounded(&self.position) && bounded(&sides)
    }

    fn new(kind: CorrectionKind, shape: u32, pose: &Pose, half_extents: [f64; 3]) -> Self {
        let (position, rotation) = (pose.translation.to_array(), pose.rotation.to_array());
        Self { kind: kind as u32, shape, position, rotation, half_extents }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_correction_with_an_invalid_number_is_malformed() {
        let pose = Pose::from_parts(glam::DVec3::new(1.0, 2.0, 3.0), glam::DQuat::IDENTITY);
        let good = [
            WorldCorrection::moved(3, &pose),
            WorldCorrection::missing(0),
            WorldCorrection::extra(&pose, [0.1; 3]),
            WorldCorrection::contact_missing(&pose, [0.1; 2]),
        ];
        for correction in good {
            assert!(correction.is_well_formed(), "{correction:?}");
            assert!(!correction.known_kind().unwrap().name().is_empty());
            let bad = [
                WorldCorrection { kind: 0, ..correction },
                WorldCorrection { position: [0.0, f64::NAN, 0.0], ..correction },
                WorldCorrection { position: [0.0, 1e5, 0.0], ..correction },
                WorldCorrection { rotation: [0.0; 4], ..correction },
                WorldCorrection { half_extents: [f64::NAN; 3], ..correction },
            ];
            assert!(bad.iter().all(|correction| !correction.is_well_formed()));
        }
        assert!(!WorldCorrection { shape: NO_SHAPE, ..good[0] }.is_well_formed());
        assert!(!WorldCorrection { half_extents: [0.1, 0.0, 0.1], ..good[2] }.is_well_formed());
    }
}
