//! The soles on which the robot stands.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::{Foot, RobotModel};

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::{cheapest_corner, clipped_to, sides_of};
use crate::robot::ankle_limits::AnkleLimits;
use crate::robot::underside::Underside;

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
    /// The separate pads of the flat part, if it has several: convex polygons, m.
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

    /// What the foot touches of a supported part of the declared sole (sole frame, m): the hull of
    /// what its pads touch.
    pub(crate) fn touched(&self, support: SolePolygon) -> SolePolygon {
        if self.flat_part == self.polygon {
            return support;
        }
        if self.pads.is_empty() {
            return reduced(clipped(support, &self.flat_part));
        }
        let mut touched = SolePolygon::new();
        for pad in &self.pads {
            let part = reduced(clipped(support.clone(), pad));
            let both = ConvexRegion::hull(touched.iter().chain(&part).copied());
            touched = reduced(both.vertices().iter().copied().collect());
        }
        touched
    }

    /// The region (world x and y, m) in which the ankle can hold the robot's weight when the whole
    /// sole is supported.
    pub fn ankle_support_region(&self, world_from_sole: &Pose) -> ConvexRegion {
        ConvexRegion::seen_from_above(world_from_sole, &self.ankle_limits.clip(&self.flat_part))
    }
}

/// A polygon with as many vertices as two clipped ones.
type LargePolygon = BoundedVec<DVec2, { 2 * POLYGON_VERTICES_MAX }>;

/// The part of a polygon in another one, which is convex.
fn clipped(polygon: SolePolygon, within: &[DVec2]) -> LargePolygon {
    let whole = polygon.into_iter().collect();
    sides_of(within).iter().fold(whole, |kept, side| clipped_to(&kept, side))
}

/// A polygon without its cheapest corners, which only shrinks it.
fn reduced(mut polygon: LargePolygon) -> SolePolygon {
    while polygon.len() > POLYGON_VERTICES_MAX {
        polygon.remove(cheapest_corner(&polygon).0);
    }
    polygon.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<DVec2> {
        [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
            .map(DVec2::from)
            .to_vec()
    }

    /// A sole of 0.2 x 0.1 m that stands on four studs of 2 x 2 cm at its corners.
    fn studded() -> Sole {
        let pads = [[-0.09, -0.04], [-0.09, 0.04], [0.09, -0.04], [0.09, 0.04]];
        let pad = |[x, y]: [f64; 2]| rectangle([x - 0.01, y - 0.01], [x + 0.01, y + 0.01]);
        Sole {
            link: 0,
            link_from_sole: Pose::IDENTITY,
            polygon: rectangle([-0.11, -0.06], [0.11, 0.06]),
            flat_part: rectangle([-0.1, -0.05], [0.1, 0.05]),
            pads: pads.map(pad).to_vec(),
            ankle_limits: AnkleLimits::default(),
        }
    }

    fn extent(polygon: &[DVec2]) -> (DVec2, DVec2) {
        polygon.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
            (low.min(*at), high.max(*at))
        })
    }

    #[test]
    fn a_sole_on_studs_touches_even_ground_with_all_of_them() {
        let sole = studded();
        let touched = sole.touched(sole.polygon.iter().copied().collect());
        let (low, high) = extent(&touched);
        assert!(low.abs_diff_eq(DVec2::new(-0.1, -0.05), 1e-6), "{low}");
        assert!(high.abs_diff_eq(DVec2::new(0.1, 0.05), 1e-6), "{high}");
    }

    #[test]
    fn studs_beyond_an_edge_carry_nothing() {
        let sole = studded();
        let ground = rectangle([-0.11, -0.06], [0.07, 0.06]);
        let (low, high) = extent(&sole.touched(ground.into_iter().collect()));
        assert!(low.abs_diff_eq(DVec2::new(-0.1, -0.05), 1e-6), "{low}");
        assert!(high.abs_diff_eq(DVec2::new(-0.08, 0.05), 1e-6), "{high}");
    }
}
