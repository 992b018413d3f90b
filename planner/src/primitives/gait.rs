//! The parameters of a robot's primitive trajectories, all derived from the robot.

use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::geometry::convex_region::ConvexRegion;
use crate::primitives::level_sole::{LevelSole, side_of};
use crate::robot::mechanism::Mechanism;

/// How far a neutral swing foot stays from what may lie between the placements, m: obstacles up to
/// this height do not matter there.
pub const SPLIT: f64 = 0.02;

/// What shapes the primitives of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Gait {
    /// The largest share of its reach that either leg uses in a primitive configuration.
    pub leg_extension: f64,
    /// How far beside the stance foot the swing foot is in the middle of a swing, m.
    pub width: f64,
    /// The steepest placement that the primitives use, rad.
    pub tilt: f64,
    /// How high a foot is lifted along its sole's normal before it travels, m.
    pub lift_height: f64,
    /// How far the root rolls over to the side of the foot that carries it, rad.
    pub roll: f64,
    /// How far inward of the middle of the foot that carries it the centre of mass stands, m.
    pub lean: f64,
}

/// What is chosen of a gait, relative to the robot.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// [`Gait::tilt`].
    pub tilt: f64,
    /// The reach, as a multiple of what the standing posture uses.
    pub reach: f64,
    /// The width, as a multiple of the standing posture's.
    pub width: f64,
    /// [`Gait::roll`].
    pub roll: f64,
    /// [`Gait::lean`], as a share of what the sole's width and the margin leave.
    pub lean: f64,
}

impl Gait {
    /// The gait of a robot in a style. `foot_radius` (m) bounds how far any part of a foot is from
    /// its ankle to the side, `margin` (m) how near to the edge of its support the centre of mass
    /// may come.
    pub fn new(
        robot: &Mechanism,
        style: &Style,
        foot_radius: f64,
        clearance: f64,
        margin: f64,
    ) -> Self {
        let level_soles = [0, 1].map(|limb| standing_level_sole(robot, limb));
        let apart = (level_soles[0].origin - level_soles[1].origin).truncate().length();
        let inward = [0, 1].map(|limb| inward_extent(&robot.soles[limb].polygon, limb) - margin);
        Self {
            leg_extension: (style.reach * robot.standing_leg_extension).min(LEG_EXTENSION_MAX),
            width: style.width * apart,
            tilt: style.tilt,
            lift_height: SPLIT + libm::sin(style.tilt) * foot_radius + clearance + LIFT_MARGIN,
            roll: style.roll,
            lean: style.lean * inward[0].min(inward[1]).max(0.0),
        }
    }

    /// Whether every number is one that a gait can have.
    pub fn is_sound(&self) -> bool {
        let is_length = |value: f64| value > 0.0 && value < 2.0;
        let is_posture = self.leg_extension > 0.0
            && self.leg_extension <= 1.0
            && self.roll.abs() < 1.0
            && (0.0..1.0).contains(&self.lean);
        is_posture
            && is_length(self.width)
            && is_length(self.lift_height)
            && (0.0..1.0).contains(&self.tilt)
    }
}

/// How far the edge of a sole is from its middle, toward the other foot, m.
fn inward_extent(polygon: &[DVec2], limb: usize) -> f64 {
    let region = ConvexRegion::hull(polygon.iter().copied());
    let middle = region.centroid();
    let beyond = middle - side_of(limb) * DVec2::Y;
    region.nearest_inside(beyond, 0.0).distance(middle)
}

/// The largest share of a leg's reach that a gait uses.
const LEG_EXTENSION_MAX: f64 = 0.99;
/// What a lift is higher than it must be, m.
const LIFT_MARGIN: f64 = 0.004;

/// Where a foot stands in the standing posture with the root at the origin.
pub fn standing_level_sole(robot: &Mechanism, limb: usize) -> LevelSole {
    let root_from_sole: Pose = robot.legs[limb].root_from_sole(&robot.standing_q);
    LevelSole::of(&robot.legs[limb], &root_from_sole)
}
