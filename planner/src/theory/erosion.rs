//! Lemma 1: which placements are reachable from every placement of a cylinder [Grey 5.4].

use std::f64::consts::PI;

/// A set of placements of one foot: all whose position is within a radius of one position, and
/// whose yaw is within half the extent of one yaw [Grey 5.4].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// r, m.
    pub radius: f64,
    /// The whole extent of the yaw, rad.
    pub yaw_extent: f64,
}

impl Cylinder {
    /// Its volume in SE(2), m^2 rad.
    pub fn volume(&self) -> f64 {
        PI * self.radius * self.radius * self.yaw_extent
    }
}

/// How far the boundary of a reachable set in SE(2) moves inward, so that the rest is reachable
/// from every placement of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Erosion {
    /// Across x and y, m.
    pub distance: f64,
    /// Along the yaw, rad.
    pub yaw: f64,
}

impl Erosion {
    /// Lemma 1 as printed, on slices along the yaw: an erosion by the radius alone. It holds for
    /// shapes in the plane that are shifted, and not in SE(2): a stance that turns also turns and
    /// shifts what it reaches.
    pub fn printed(cylinder: Cylinder) -> Self {
        Self { distance: cylinder.radius, yaw: 0.0 }
    }

    /// A sufficient erosion for steps of at most `step_max` (m, R_max). A stance that shifts by t
    /// and turns by phi moves a placement p, as it sees it, by at most |t| + 2 |p| sin(phi / 2),
    /// and turns it by phi; within the cylinder |t| is at most the radius, and phi half the extent.
    pub fn sufficient(cylinder: Cylinder, step_max: f64) -> Self {
        let shift = 2.0 * step_max * libm::sin(0.25 * cylinder.yaw_extent);
        Self { distance: cylinder.radius + shift, yaw: 0.5 * cylinder.yaw_extent }
    }
}
