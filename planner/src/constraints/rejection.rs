//! Rejections: the reasons why a configuration or a motion is not part of a plan.

use crate::robot::posture_ik::PostureError;

/// Why a configuration or a motion was rejected. Every rejection is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Rejection {
    /// A leg does not reach its sole within its joint limits.
    Unreachable,
    /// The centre of mass is outside of the support polygon or its margin.
    Balance,
    /// A joint needs more than its usable effort.
    Torque,
    /// The robot collides with the world.
    Collision,
    /// The robot collides with itself.
    SelfCollision,
    /// A stance foot moves between two waypoints.
    FootDrift,
    /// The motion needs too many steps, or a joint jumps.
    Discontinuous,
}

impl Rejection {
    /// Number of kinds.
    pub const COUNT: usize = 7;
    /// Names in reports, by discriminant.
    pub const NAMES: [&'static str; Self::COUNT] = [
        "unreachable",
        "balance",
        "torque",
        "collision",
        "self_collision",
        "foot_drift",
        "discontinuous",
    ];
}

impl From<PostureError> for Rejection {
    fn from(error: PostureError) -> Self {
        match error {
            PostureError::Unreachable => Self::Unreachable,
            PostureError::Balance => Self::Balance,
        }
    }
}
