//! A pose in space.

use glam::DQuat;
use surefoot_shared_types::Pose as SpatialPose;
use surefoot_shared_types::base::spatial::rotation_from_rpy;
use surefoot_shared_types::plan_format::blocks::PoseBlock;

/// A position and a rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position, m.
    pub position: [f64; 3],
    /// Rotation, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

impl Pose {
    /// A pose without rotation at `x`, `y`, `z` (m).
    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self { position: [x, y, z], rotation: [0.0, 0.0, 0.0, 1.0] }
    }

    /// The same position with a rotation by roll, pitch and yaw (rad) about the fixed axes x, y
    /// and z, in this order.
    pub fn with_rpy(self, roll: f64, pitch: f64, yaw: f64) -> Self {
        Self { rotation: rotation_from_rpy(roll, pitch, yaw).to_array(), ..self }
    }
}

impl From<SpatialPose> for Pose {
    fn from(pose: SpatialPose) -> Self {
        Self { position: pose.translation.to_array(), rotation: pose.rotation.to_array() }
    }
}

impl From<Pose> for SpatialPose {
    fn from(pose: Pose) -> Self {
        Self::from_parts(pose.position.into(), DQuat::from_array(pose.rotation))
    }
}

impl From<Pose> for PoseBlock {
    fn from(pose: Pose) -> Self {
        Self { xyz: pose.position, quat_xyzw: pose.rotation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_x_lays_z_along_minus_y() {
        let pose = Pose::at(1.0, 2.0, 3.0).with_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
        let z = DQuat::from_array(pose.rotation) * glam::DVec3::Z;
        assert!(z.distance(glam::DVec3::NEG_Y) < 1e-12 && pose.position == [1.0, 2.0, 3.0]);
    }
}
