//! The parameters of a robot's primitive trajectories, all derived from the robot.

use bytemuck::{Pod, Zeroable};
use surefoot_shared_types::Pose;

use super::stand::Stand;
use crate::body::Body;

/// The steepest placement that primitives use, rad.
pub const TILT_MAX: f64 = 0.1;
/// How far a neutral swing foot stays from what may lie between the placements, m: obstacles up to this height do not
/// matter there.
pub const SPLIT: f64 = 0.02;

/// What shapes the primitives of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Gait {
    /// The largest share of its reach that either leg uses in a primitive configuration.
    pub reach_share: f64,
    /// How far beside the stance foot the swing foot is in the middle of a swing, m.
    pub width: f64,
    /// How high a foot is lifted along its sole's normal before it travels, m.
    pub lift: f64,
}

impl Gait {
    /// The gait that uses a share of the standing posture's reach and a multiple of its width. `foot_radius` (m) bounds how
    /// far any part of a foot is from its ankle to the side.
    pub fn new(body: &Body, reach_factor: f64, width_factor: f64, foot_radius: f64, clearance: f64) -> Self {
        let stands = [0, 1].map(|limb| standing(body, limb));
        let apart = (stands[0].origin - stands[1].origin).truncate().length();
        Self {
            reach_share: reach_factor * body.standing_reach_share,
            width: width_factor * apart,
            lift: SPLIT + libm::sin(TILT_MAX) * foot_radius + clearance + LIFT_MARGIN,
        }
    }

    /// Whether every number is one that a gait can have.
    pub fn is_sound(&self) -> bool {
        let is_length = |value: f64| value > 0.0 && value < 2.0;
        self.reach_share > 0.0 && self.reach_share <= 1.0 && is_length(self.width) && is_length(self.lift)
    }
}

/// What a lift is higher than it must be, m.
const LIFT_MARGIN: f64 = 0.004;

/// Where a foot stands in the standing posture with the root at the origin.
pub fn standing(body: &Body, limb: usize) -> Stand {
    let root_from_sole: Pose = body.legs[limb].root_from_sole(&body.standing_q);
    Stand::of(&body.legs[limb], &root_from_sole)
}
