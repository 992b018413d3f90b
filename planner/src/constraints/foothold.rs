//! A foot placement in the graph, and the modes it makes.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::message::SupportMode;

use crate::constraints::constraints::Mode;
use crate::geometry::convex_region::ConvexRegion;
use crate::robot::crouch::Crouch;
use crate::robot::mechanism::Mechanism;

/// A place where a foot can stand.
#[derive(Debug, Clone)]
pub struct Foothold {
    /// Which foot.
    pub limb: usize,
    /// The sole's pose in the world.
    pub world_from_sole: Pose,
    /// The supported part of the sole, in the sole frame.
    pub support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    /// The supported part of the sole in world x and y, or that of it which the ankle can hold.
    pub region: ConvexRegion,
    /// The crouch there: that of the nearest vertex of the guide route.
    pub crouch: Crouch,
}

impl Foothold {
    /// A placement with its support polygon (sole frame).
    pub fn new(
        limb: usize,
        world_from_sole: Pose,
        support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    ) -> Self {
        Self {
            limb,
            world_from_sole,
            region: ConvexRegion::seen_from_above(&world_from_sole, &support),
            support,
            crouch: Crouch::UPRIGHT,
        }
    }

    /// The placement of a robot's foot with its support polygon (sole frame), of which counts what
    /// the ankle can hold.
    pub fn of(
        robot: &Mechanism,
        limb: usize,
        world_from_sole: Pose,
        support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    ) -> Self {
        let region = ConvexRegion::seen_from_above(
            &world_from_sole,
            &robot.ankle_limits[limb].clip(&support),
        );
        Self { limb, world_from_sole, support, region, crouch: Crouch::UPRIGHT }
    }

    /// The placement of a robot's foot with all of its sole carried.
    pub fn whole(robot: &Mechanism, limb: usize, world_from_sole: Pose) -> Self {
        Self::of(robot, limb, world_from_sole, robot.sole_polygons[limb].iter().copied().collect())
    }

    /// The distance between two placements' sole frames, D(T) of the transition between them
    /// [Grey 4.4.2], m.
    pub fn distance(&self, other: &Self) -> f64 {
        self.world_from_sole.translation.distance(other.world_from_sole.translation)
    }
}

/// Two placements of different feet, the left one first.
pub fn left_and_right<'a>(a: &'a Foothold, b: &'a Foothold) -> [&'a Foothold; 2] {
    if a.limb == 0 { [a, b] } else { [b, a] }
}

/// The mode in which `stance` alone carries the robot.
pub fn single_mode(stance: &Foothold) -> Mode {
    let support = if stance.limb == 0 { SupportMode::Left } else { SupportMode::Right };
    let mut regions = [ConvexRegion::default(), ConvexRegion::default()];
    regions[stance.limb] = stance.region.clone();
    let region = stance.region.clone();
    Mode {
        support,
        world_from_soles: [stance.world_from_sole; 2],
        regions,
        depth: region.margin(region.centroid()),
        region,
        start: None,
    }
}

/// The mode in which both feet carry the robot; the placements may come in either order.
pub fn double_mode(a: &Foothold, b: &Foothold) -> Mode {
    let [left, right] = left_and_right(a, b);
    let vertices = left.region.vertices().iter().chain(right.region.vertices()).copied();
    let region = ConvexRegion::hull(vertices);
    Mode {
        support: SupportMode::Double,
        world_from_soles: [left.world_from_sole, right.world_from_sole],
        regions: [left.region.clone(), right.region.clone()],
        depth: region.margin(region.centroid()),
        region,
        start: None,
    }
}
