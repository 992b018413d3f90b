//! Boxes of the world that stand upright.

use glam::{DVec2, DVec3};

/// A box turned about the vertical only.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UprightBox {
    /// Its centre in the world, m.
    pub(crate) center: DVec3,
    /// The direction of its x axis, seen from above.
    pub(crate) axis: DVec2,
    /// Half of each side, m.
    pub(crate) half_extents: DVec3,
}
