//! The soles on which the robot stands.

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{Foot, RobotModel};

use crate::geometry::convex_region::ConvexRegion;
use crate::robot::ankle_limits::AnkleLimits;
use crate::robot::underside::Underside;

/// A sole: the flat bottom of a foot.
#[derive(Debug, Clone)]
pub struct Sole {
    /// Index of the foot's link.
    pub link: usize,
    /// Pose of the sole frame in the foot link's frame.
    pub link_from_sole: Pose,
    /// Outline in the sole frame (m), counter-clockwise.
    pub polygon: Vec<DVec2>,
    /// The part of it that touches level ground, m.
    pub flat_part: Vec<DVec2>,
    /// The pads of the flat part, convex polygons, m; empty where the whole sole touches.
    pub pads: Vec<Vec<DVec2>>,
    /// Limits of the centre of pressure from the ankle's torques.
    pub ankle_limits: AnkleLimits,
}

impl Sole {
    /// The sole of a foot.
    pub(crate) fn new(model: &RobotModel, foot: &Foot, ankle_limits: AnkleLimits) -> Self {
        let Underside { flat_part, pads } = Underside::of(model, foot);
        Self {
            link: foot.link,
            link_from_sole: foot.link_from_sole,
            polygon: foot.polygon.clone(),
            flat_part,
            pads,
            ankle_limits,
        }
    }

    /// The region (world x and y, m) in which the ankle can hold the robot's weight when the whole
    /// sole is supported.
    pub fn ankle_support_region(&self, world_from_sole: &Pose) -> ConvexRegion {
        ConvexRegion::seen_from_above(world_from_sole, &self.ankle_limits.clip(&self.flat_part))
    }
}
