//! Footholds and the modes that they form.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::message::SupportMode;

use crate::constraints::mode::Mode;
use crate::geometry::convex_region::ConvexRegion;
use crate::robot::crouch::Crouch;
use crate::robot::mechanism::Mechanism;

/// A pose at which a foot can stand, with its support.
#[derive(Debug, Clone)]
pub struct Foothold {
    /// The foot.
    pub limb: usize,
    /// Pose of the sole in the world.
    pub world_from_sole: Pose,
    /// Supported part of the sole, in the sole frame, m.
    pub support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    /// Supported part of the sole within the ankle limits, in world x and y.
    pub region: ConvexRegion,
    /// Crouch of the robot there: that of the nearest vertex of the guide route.
    pub crouch: Crouch,
}

impl Foothold {
    /// A foothold with this support polygon (sole frame, m), without ankle limits.
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

    /// A foothold of a robot where this part of the sole (sole frame, m) is supported, within the
    /// ankle limits.
    pub fn of(
        robot: &Mechanism,
        limb: usize,
        world_from_sole: Pose,
        support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    ) -> Self {
        let sole = &robot.soles[limb];
        let region =
            ConvexRegion::seen_from_above(&world_from_sole, &sole.ankle_limits.clip(&support));
        Self { limb, world_from_sole, support, region, crouch: Crouch::UPRIGHT }
    }

    /// A foothold of a robot with the whole sole supported.
    pub fn whole(robot: &Mechanism, limb: usize, world_from_sole: Pose) -> Self {
        let support = robot.soles[limb].flat_part.iter().copied().collect();
        Self::of(robot, limb, world_from_sole, support)
    }

    /// Distance between the sole frames of two footholds, m: D(T) of the transition between them
    /// [Grey 4.4.2].
    pub fn distance(&self, other: &Self) -> f64 {
        self.world_from_sole.translation.distance(other.world_from_sole.translation)
    }

    /// The placement of the foot, as stage P and C_S take it.
    pub fn placement(&self, robot: &Mechanism) -> FootPlacement {
        FootPlacement {
            limb: self.limb,
            world_from_sole: self.world_from_sole,
            is_whole: is_whole(robot, self.limb, &self.support),
        }
    }
}

/// The pose of a foot, with or without full support.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootPlacement {
    /// The foot.
    pub limb: usize,
    /// Pose of its sole in the world.
    pub world_from_sole: Pose,
    /// Whether the whole sole is supported, as on flat ground.
    pub is_whole: bool,
}

/// Placements of the left and the right foot.
pub type FootPair = [FootPlacement; 2];

/// Whether a support polygon (sole frame, m) reaches every corner of the sole's flat part.
pub fn is_whole(robot: &Mechanism, limb: usize, support: &[DVec2]) -> bool {
    let support = ConvexRegion::hull(support.iter().copied());
    let flat_part = &robot.soles[limb].flat_part;
    flat_part.iter().all(|&corner| support.margin(corner) >= -UNSUPPORTED_RIM_MAX)
}

/// Widest unsupported rim of a sole that counts as whole, m.
const UNSUPPORTED_RIM_MAX: f64 = 2e-3;

/// Two footholds of different feet, the left one first.
pub fn left_and_right<'a>(a: &'a Foothold, b: &'a Foothold) -> [&'a Foothold; 2] {
    if a.limb == 0 { [a, b] } else { [b, a] }
}

/// The mode of single support on `stance`.
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

/// The mode of double support on two footholds of different feet, in either order.
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
