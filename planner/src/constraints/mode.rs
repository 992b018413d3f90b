//! Modes: fixed contacts, and the region of the centre of mass that follows from them
//! [Grey 4.4.1].

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::SupportMode;

use crate::geometry::convex_region::ConvexRegion;

/// A mode: the feet that carry the robot, their poses, and the region of the centre of mass.
#[derive(Debug, Clone)]
pub struct Mode {
    /// The feet that carry the robot.
    pub support: SupportMode,
    /// World poses of the stance soles, by limb; the entry of a swing foot is not used.
    pub world_from_soles: [Pose; 2],
    /// Support polygon of each stance foot in world x and y.
    pub regions: [ConvexRegion; 2],
    /// Region of the centre of mass in world x and y.
    pub region: ConvexRegion,
    /// Distance of the region's centroid to its border, m.
    pub depth: f64,
    /// Balance of the robot at the start of the plan, for motions that begin there.
    pub start: Option<StartBalance>,
}

/// Balance of a robot that stands at the start of a plan. It may be nearer to the border of its
/// support polygon than a plan is allowed to be.
#[derive(Debug, Clone, Copy)]
pub struct StartBalance {
    /// Centre of mass in world x and y, m.
    pub com: DVec2,
    /// Least margin that the checker accepts, m.
    pub margin_min: f64,
}

impl Mode {
    /// Whether a foot carries the robot.
    pub fn is_stance(&self, limb: usize) -> bool {
        self.support.carries(limb)
    }

    /// The swing foot; `None` in double support.
    pub fn swing(&self) -> Option<usize> {
        [0, 1].into_iter().find(|&limb| !self.is_stance(limb))
    }
}
