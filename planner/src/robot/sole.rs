//! The soles on which the robot stands.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::{Foot, RobotModel};

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::{cheapest_corner, clipped_to, sides_of};
use crate::robot::ankle_limits::AnkleLimits;
use crate::robot::underside::flat_part;

/// A polygon in the frame of a sole, m.
pub(crate) type SolePolygon = BoundedVec<DVec2, POLYGON_VERTICES_MAX>;

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
    /// Limits of the centre of pressure from the ankle's torques.
    pub ankle_limits: AnkleLimits,
}

impl Sole {
    /// The sole of a foot.
    pub(crate) fn new(model: &RobotModel, foot: &Foot, ankle_limits: AnkleLimits) -> Self {
        Self {
            link: foot.link,
            link_from_sole: foot.link_from_sole,
            polygon: foot.polygon.clone(),
            flat_part: flat_part(model, foot),
            ankle_limits,
        }
    }

    /// What the foot touches of a supported part of the declared sole (sole frame, m).
    pub(crate) fn touched(&self, support: SolePolygon) -> SolePolygon {
        if self.flat_part == self.polygon {
            return support;
        }
        let whole: BoundedVec<DVec2, { 2 * POLYGON_VERTICES_MAX }> =
            support.iter().copied().collect();
        let sides = sides_of(&self.flat_part);
        let mut touched = sides.iter().fold(whole, |kept, side| clipped_to(&kept, side));
        while touched.len() > POLYGON_VERTICES_MAX {
            touched.remove(cheapest_corner(&touched).0);
        }
        touched.into_iter().collect()
    }

    /// The region (world x and y, m) in which the ankle can hold the robot's weight when the whole
    /// sole is supported.
    pub fn ankle_support_region(&self, world_from_sole: &Pose) -> ConvexRegion {
        ConvexRegion::seen_from_above(world_from_sole, &self.ankle_limits.clip(&self.flat_part))
    }
}
