//! Root poses of vertices of Gamma_P: a mid-feet pose and a root posture over it.

use surefoot_shared_types::Pose;

use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::robot::crouch::Crouch;

/// Index of a root posture.
pub type PostureId = u16;

/// The upright posture.
pub(crate) const UPRIGHT: PostureId = 0;

/// A root pose over a pair of soles on level ground.
#[derive(Debug, Clone, Copy)]
pub struct RootPosture {
    /// The leg extension and the lean.
    pub crouch: Crouch,
    /// The root in the mid-feet frame.
    pub mid_feet_from_root: Pose,
}

/// A mid-feet pose with the root posture over it.
#[derive(Debug, Clone, Copy)]
pub struct RootVertex {
    /// The mid-feet pose.
    pub pose: MidFeetPose,
    /// The root posture.
    pub posture: PostureId,
}
