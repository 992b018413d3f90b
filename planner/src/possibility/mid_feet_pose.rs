//! The mid-feet pose: the root pose given by the ground below it, and steps between two of them.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};
use surefoot_shared_types::config::scenario::StancePose;

use crate::possibility::tuning::{
    HEADING_WEIGHT, HEIGHT_WEIGHT, TURN_IN_PLACE_MAX, TURN_WALKING_MAX, TURNING_DISTANCE_MIN,
    WALKING_DEVIATION_MAX, WALKING_STRIDE_SHARE_MIN,
};

/// The pose midway between both soles ("mid-feet frame", IHMC).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MidFeetPose {
    /// The point midway between both soles, world, m.
    pub position: DVec3,
    /// The heading about the world's z axis, rad.
    pub yaw: f64,
}

impl MidFeetPose {
    /// The mid-feet pose of a start or goal stance.
    pub fn of_stance(stance: &StancePose) -> Self {
        Self { position: stance.position, yaw: stance.yaw }
    }

    /// The position and heading of a sole.
    pub fn of_sole(world_from_sole: &Pose) -> Self {
        Self { position: world_from_sole.translation, yaw: yaw_of(world_from_sole.rotation) }
    }

    /// The mid-feet frame in the world: x forward, z up.
    pub fn world_from_mid_feet(&self) -> Pose {
        Pose::from_parts(self.position, rotation_about(DVec3::Z, self.yaw))
    }

    /// Ideal sole pose of a foot in the world, `stance_width` metres beside the other sole.
    pub fn world_from_ideal_sole(&self, limb: usize, stance_width: f64) -> Pose {
        let side = if limb == 0 { 0.5 } else { -0.5 };
        self.world_from_mid_feet()
            * Pose::from_parts(DVec3::Y * side * stance_width, glam::DQuat::IDENTITY)
    }

    /// The metric of Gamma_P, m: Euclidean over the position, with a weight on height, and the
    /// heading, weighted by 0.3 m/rad.
    pub fn distance(&self, other: &Self) -> f64 {
        let turn = HEADING_WEIGHT * wrap_angle(other.yaw - self.yaw);
        libm::sqrt(self.position_distance_squared(other.position) + turn * turn)
    }

    /// The squared distance to a position in the same metric without the heading, m^2.
    pub fn position_distance_squared(&self, position: DVec3) -> f64 {
        let offset = position - self.position;
        DVec3::new(offset.x, offset.y, HEIGHT_WEIGHT * offset.z).length_squared()
    }

    /// The pose at a fraction of the path to another.
    pub fn interpolate(&self, other: &Self, fraction: f64) -> Self {
        let yaw = self.yaw + fraction * wrap_angle(other.yaw - self.yaw);
        Self { position: self.position.lerp(other.position, fraction), yaw }
    }

    /// The horizontal offset to another pose, m.
    pub fn horizontal_offset_to(&self, other: &Self) -> DVec2 {
        (other.position - self.position).truncate()
    }

    /// The next pose toward `target`, at most `stride` metres ahead. `heading_offset` (rad) is the
    /// heading relative to the direction of the target: 0 to walk there, pi if the path is walked
    /// from the target to here.
    pub fn step_toward(&self, target: &Self, stride: f64, heading_offset: f64) -> Self {
        let offset = self.horizontal_offset_to(target);
        let length = offset.length();
        let heading = if length < TURNING_DISTANCE_MIN {
            target.yaw
        } else {
            libm::atan2(offset.y, offset.x) + heading_offset
        };
        let turn = wrap_angle(heading - self.yaw);
        let is_walking = length > WALKING_STRIDE_SHARE_MIN * stride
            && (turn.abs() <= WALKING_DEVIATION_MAX || length < TURNING_DISTANCE_MIN);
        let turn_max = if is_walking { TURN_WALKING_MAX } else { TURN_IN_PLACE_MAX };
        let fraction = if is_walking { (stride / length).min(1.0) } else { 0.0 };
        Self {
            position: self.position + (fraction * offset).extend(0.0),
            yaw: self.yaw + turn.clamp(-turn_max, turn_max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn pose(x: f64, y: f64, yaw: f64) -> MidFeetPose {
        MidFeetPose { position: DVec3::new(x, y, 0.0), yaw }
    }

    #[test]
    fn steps_toward_a_target_end_at_it() {
        for (yaw, heading_offset) in [(0.0, 0.0), (2.5, 0.0), (-1.0, PI), (0.3, FRAC_PI_2)] {
            let target = pose(3.0, 1.0, 0.4);
            let mut at = pose(0.0, 0.0, yaw);
            for _ in 0..60 {
                at = at.step_toward(&target, 0.25, heading_offset);
            }
            assert!(at.distance(&target) < 0.06, "{at:?}");
        }
    }

    #[test]
    fn a_path_walked_from_its_end_has_the_opposite_heading() {
        let (goal, target) = (pose(0.0, 0.0, 0.0), pose(-3.0, 0.0, 0.0));
        let walked = goal.step_toward(&target, 0.25, PI);
        assert!(walked.yaw.abs() < 1e-12 && walked.position.x < -0.2);
    }

    #[test]
    fn a_robot_with_a_lateral_heading_offset_sidesteps() {
        let beside = pose(0.0, 0.0, 0.0).step_toward(&pose(0.0, 3.0, 0.0), 0.25, -FRAC_PI_2);
        assert!(beside.yaw.abs() < 1e-12 && (beside.position.y - 0.25).abs() < 1e-12, "{beside:?}");
    }

    #[test]
    fn the_robot_turns_in_place_before_it_walks_sideways() {
        let turned = pose(0.0, 0.0, 0.0).step_toward(&pose(0.0, 3.0, 0.0), 0.25, 0.0);
        assert_eq!(turned.position, DVec3::ZERO);
        assert!((turned.yaw - TURN_IN_PLACE_MAX).abs() < 1e-12);
    }
}
