//! The parameters of a robot's primitive trajectories, all derived from the robot.

use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use surefoot_shared_types::Pose;

use crate::geometry::convex_region::ConvexRegion;
use crate::primitives::level_sole::{LevelSole, side_of};
use crate::primitives::tuning::{GAIT_LEG_EXTENSION_MAX, GAIT_LIFT_MARGIN};
use crate::robot::mechanism::Mechanism;

/// Height up to which obstacles between the placements do not matter, m: the neutral swing foot
/// stays above it.
pub const SPLIT: f64 = 0.02;

/// The parameters that shape the primitives of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Gait {
    /// The largest share of its reach that either leg uses in a primitive configuration.
    pub leg_extension: f64,
    /// Lateral distance of the swing foot from the stance foot in the middle of a swing, m.
    pub width: f64,
    /// The steepest placement that the primitives use, rad.
    pub tilt: f64,
    /// Height to which a foot is lifted along its sole's normal before it moves across, m.
    pub lift_height: f64,
    /// Roll of the root toward the stance foot, rad.
    pub roll: f64,
    /// Distance of the centre of mass inward of the stance foot's centroid, m.
    pub lean: f64,
}

/// The choices that define a gait, relative to the robot.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// [`Gait::tilt`].
    pub tilt: f64,
    /// The leg extension, as a multiple of the standing posture's.
    pub reach: f64,
    /// The width, as a multiple of the standing posture's.
    pub width: f64,
    /// [`Gait::roll`].
    pub roll: f64,
    /// [`Gait::lean`], as a share of the space that the sole's width and the margin leave.
    pub lean: f64,
}

impl Gait {
    /// The gait of a robot in a style. `foot_radius` (m) is the largest horizontal distance of any
    /// part of a foot from its ankle, `margin` (m) the least distance of the centre of mass from
    /// the edge of its support.
    pub fn new(
        robot: &Mechanism,
        style: &Style,
        foot_radius: f64,
        clearance: f64,
        margin: f64,
    ) -> Self {
        let level_soles = [0, 1].map(|limb| standing_level_sole(robot, limb));
        let distance = (level_soles[0].origin - level_soles[1].origin).truncate().length();
        let inward = [0, 1].map(|limb| inward_extent(&robot.soles[limb].polygon, limb) - margin);
        Self {
            leg_extension: (style.reach * robot.standing_leg_extension).min(GAIT_LEG_EXTENSION_MAX),
            width: style.width * distance,
            tilt: style.tilt,
            lift_height: SPLIT + libm::sin(style.tilt) * foot_radius + clearance + GAIT_LIFT_MARGIN,
            roll: style.roll,
            lean: style.lean * inward[0].min(inward[1]).max(0.0),
        }
    }

    /// Whether every parameter is in its range.
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

/// Distance from a sole's centroid to its edge toward the other foot, m.
fn inward_extent(polygon: &[DVec2], limb: usize) -> f64 {
    let region = ConvexRegion::hull(polygon.iter().copied());
    let centroid = region.centroid();
    let beyond = centroid - side_of(limb) * DVec2::Y;
    region.nearest_inside(beyond, 0.0).distance(centroid)
}

/// The level sole of a foot in the standing posture with the root at the origin.
pub fn standing_level_sole(robot: &Mechanism, limb: usize) -> LevelSole {
    let root_from_sole: Pose = robot.legs[limb].root_from_sole(&robot.standing_q);
    LevelSole::of(&robot.legs[limb], &root_from_sole)
}
