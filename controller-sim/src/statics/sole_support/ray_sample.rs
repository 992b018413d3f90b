//! A sample of the air under a foot.

use glam::{DVec2, DVec3};

use crate::statics::tuning::PLANE_DISTANCE_MAX;
use crate::statics::underside::SolePoint;

/// A ray down from the underside of a foot.
#[derive(Clone, Copy)]
pub(super) struct RaySample {
    /// Where it begins.
    pub(super) point: SolePoint,
    /// Distance from the foot down to the surface, m; infinite over a void.
    pub(super) air: f64,
    /// The most air within the distance by which the real foot may be displaced, m.
    pub(super) most_air: f64,
    /// The surface's outward unit normal in the world.
    pub(super) normal: DVec3,
    /// The growth of the air along the plane of the ground, m per m.
    pub(super) gradient: DVec2,
    /// Whether the surface can carry.
    pub(super) is_carrying: bool,
    /// Whether the surface is curved.
    pub(super) is_round: bool,
}

impl RaySample {
    /// The depth of the ground below the sole plane, m.
    pub(super) fn depth(&self) -> f64 {
        self.air - self.point.height
    }

    /// Whether another sample lies in the plane of the ground at this one, and the foot is flat.
    pub(super) fn is_in_plane(&self, other: &RaySample) -> bool {
        let air = self.air + self.gradient.dot(other.point.at - self.point.at);
        other.is_carrying == self.is_carrying
            && other.point.height == self.point.height
            && (other.air - air).abs() <= PLANE_DISTANCE_MAX
    }
}
