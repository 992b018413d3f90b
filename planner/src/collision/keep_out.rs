//! Keep-out zones: areas where no sole may stand, whatever the shapes of the world say.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;

use crate::collision::tuning::KEEP_OUT_HEIGHT;

/// The zones where contact was found missing.
#[derive(Debug, Clone, Default)]
pub(crate) struct KeepOutZones(heapless::Vec<KeepOutZone, CORRECTIONS_MAX>);

/// The rectangle of a sole that had no support.
#[derive(Debug, Clone, Copy)]
struct KeepOutZone {
    sole_from_world: Pose,
    half_sides: DVec2,
}

impl KeepOutZones {
    /// Adds the rectangle around a sole; zones beyond [`CORRECTIONS_MAX`] are dropped.
    pub(crate) fn add(&mut self, world_from_sole: &Pose, half_sides: [f64; 2]) {
        let _ = self.0.push(KeepOutZone {
            sole_from_world: world_from_sole.inverse(),
            half_sides: half_sides.into(),
        });
    }

    /// Whether a point of the world lies in a zone.
    pub(crate) fn contain(&self, position: DVec3) -> bool {
        self.0.iter().any(|zone| zone.contains(position))
    }
}

impl KeepOutZone {
    fn contains(&self, position: DVec3) -> bool {
        let at = self.sole_from_world * position;
        at.x.abs() <= self.half_sides.x
            && at.y.abs() <= self.half_sides.y
            && at.z.abs() <= KEEP_OUT_HEIGHT
    }
}
