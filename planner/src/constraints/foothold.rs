//! Footholds and the modes that they form.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::message::SupportMode;

use crate::constraints::mode::Mode;
use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::{inner_distance, least_width};
use crate::robot::crouch::Crouch;
use crate::robot::mechanism::Mechanism;

/// The ground under a sole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// It touches the sole up to its outline.
    #[default]
    Even,
    /// It is uneven: foot placement keeps such a support away from the outline on all sides.
    Uneven,
    /// It is a mesh whose corners are near each other, uneven within the width of a sole.
    Rough,
}

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
    /// The ground under it.
    pub ground: Ground,
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
            ground: Ground::Even,
        }
    }

    /// A foothold of a robot where this part of the sole (sole frame, m) is supported, within the
    /// ankle limits. Its ground is even or uneven, as the support shows.
    pub fn of(
        robot: &Mechanism,
        limb: usize,
        world_from_sole: Pose,
        support: BoundedVec<DVec2, POLYGON_VERTICES_MAX>,
    ) -> Self {
        let sole = &robot.soles[limb];
        let region =
            ConvexRegion::seen_from_above(&world_from_sole, &sole.ankle_limits.clip(&support));
        let is_inside = |at: &DVec2| inner_distance(&sole.flat_part, *at) > ON_OUTLINE_MAX;
        let is_uneven = support.iter().all(is_inside);
        let ground = if is_uneven { Ground::Uneven } else { Ground::Even };
        let crouch = Crouch::UPRIGHT;
        Self { limb, world_from_sole, region, support, crouch, ground }
    }

    /// The same on a mesh whose faces that carry and are inclined against the sole have edges of
    /// `corner_spacing` (m) and more.
    pub fn on_corners(self, robot: &Mechanism, corner_spacing: f64) -> Self {
        let is_near = corner_spacing.is_finite()
            && corner_spacing < ROUGH_WIDTH_SHARE * least_width(&robot.soles[self.limb].flat_part);
        Self { ground: if is_near { Ground::Rough } else { self.ground }, ..self }
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

/// Distance (m) from the outline of a sole up to which a corner of its support lies on it. On bars
/// it is 1 mm inside.
const ON_OUTLINE_MAX: f64 = 2e-3;

/// Largest distance of the corners of a mesh, as a share of a sole's width, at which they count as
/// near each other.
const ROUGH_WIDTH_SHARE: f64 = 0.5;

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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use surefoot_shared_types::config::PlannerConfig;
    use surefoot_shared_types::robot::load::load_robot;

    use super::*;

    #[test]
    #[allow(clippy::unwrap_used, reason = "the shipped robot loads")]
    fn a_support_inside_the_outline_and_near_corners_show_the_ground() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/robots/hubo/robot.toml");
        let model = load_robot(&file).unwrap();
        let robot = Mechanism::new(&model, &PlannerConfig::default()).unwrap();
        let on = |toe: f64, sides: f64| {
            let inset = |at: &DVec2| {
                let x = if at.x > 0.0 { at.x - toe } else { at.x + sides };
                DVec2::new(x, at.y - sides * at.y.signum())
            };
            let support = robot.soles[0].flat_part.iter().map(inset).collect();
            Foothold::of(&robot, 0, Pose::IDENTITY, support)
        };
        let (even, edge, uneven) = (on(0.0, 0.0), on(0.02, 0.0), on(4e-3, 4e-3));
        assert_eq!([even.ground, edge.ground], [Ground::Even; 2]);
        assert_eq!(uneven.ground, Ground::Uneven);
        // Its soles are 14 cm wide.
        let near = |spacing: f64| uneven.clone().on_corners(&robot, spacing).ground;
        assert_eq!([0.06, 0.08, f64::INFINITY].map(near), {
            [Ground::Rough, Ground::Uneven, Ground::Uneven]
        });
    }
}
