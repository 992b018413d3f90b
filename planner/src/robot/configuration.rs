//! Configurations: the pose of the root and the positions of all joints.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::interpolate;

/// A whole-body configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Configuration {
    /// Pose of the root in the world.
    pub world_from_root: Pose,
    /// Joint positions (rad or m) in the order of `RobotModel::joints`; unused entries are 0.
    pub q: [f64; JOINTS_MAX],
}

/// The configuration at fraction `t` of the motion from `a` to `b`, as the robot moves between two
/// waypoints: joints and root position linearly, root rotation along the shortest arc.
pub fn midway(a: &Configuration, b: &Configuration, t: f64) -> Configuration {
    let world_from_root = interpolate(&a.world_from_root, &b.world_from_root, t);
    let q = std::array::from_fn(|i| a.q[i] + t * (b.q[i] - a.q[i]));
    Configuration { world_from_root, q }
}
