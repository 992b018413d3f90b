//! A root pose by the ground under it, and how one leads to another.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::Mark;
use surefoot_shared_types::spatial::{rotation_about, wrap_angle, yaw_of};

/// Metres that a metre of height counts in the metric: stairs are dearer than floors.
const METRES_PER_HEIGHT: f64 = 2.0;
/// Metres that a radian of heading counts in the metric.
const METRES_PER_RADIAN: f64 = 0.3;
/// A target nearer than this (m) is approached without turning to face it.
const FACING_DISTANCE_MIN: f64 = 0.5;
/// The largest turn in place from one station to the next, rad: a step can turn a foot by as much.
const TURN_IN_PLACE_MAX: f64 = 0.2;
/// The largest turn while walking from one station to the next, rad.
const TURN_WALKING_MAX: f64 = 0.35;
/// Farther than this (rad) off its heading the robot turns before it walks.
const WALKING_DEVIATION_MAX: f64 = 0.7;

/// Where the root stands over the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// The point midway between both soles, world, m.
    pub position: DVec3,
    /// The heading about the world's z axis, rad.
    pub yaw: f64,
}

impl Station {
    /// The station of a start or goal mark.
    pub fn on(mark: &Mark) -> Self {
        Self { position: mark.position, yaw: mark.yaw }
    }

    /// Where a sole stands and faces.
    pub fn of_sole(world_from_sole: &Pose) -> Self {
        Self { position: world_from_sole.translation, yaw: yaw_of(world_from_sole.rotation) }
    }

    /// The station's frame: x ahead, z up.
    pub fn world_from_station(&self) -> Pose {
        Pose::from_parts(self.position, rotation_about(DVec3::Z, self.yaw))
    }

    /// Where a foot would ideally stand, `feet_apart` metres from the other.
    pub fn world_from_ideal_sole(&self, limb: usize, feet_apart: f64) -> Pose {
        let side = if limb == 0 { 0.5 } else { -0.5 };
        self.world_from_station()
            * Pose::from_parts(DVec3::Y * side * feet_apart, glam::DQuat::IDENTITY)
    }

    /// The metric of Gamma_P: the distance between positions, heights counted double, and a third
    /// of a metre a radian.
    pub fn distance(&self, other: &Self) -> f64 {
        let turn = METRES_PER_RADIAN * wrap_angle(other.yaw - self.yaw);
        libm::sqrt(self.place_distance_squared(other.position) + turn * turn)
    }

    /// The same to a place, without the heading, squared.
    pub fn place_distance_squared(&self, place: DVec3) -> f64 {
        let way = place - self.position;
        DVec3::new(way.x, way.y, METRES_PER_HEIGHT * way.z).length_squared()
    }

    /// The station a share of the way to another.
    pub fn toward_share(&self, other: &Self, share: f64) -> Self {
        let yaw = self.yaw + share * wrap_angle(other.yaw - self.yaw);
        Self { position: self.position.lerp(other.position, share), yaw }
    }

    /// How far it is to another, seen from above.
    pub fn way_to(&self, other: &Self) -> DVec2 {
        (other.position - self.position).truncate()
    }

    /// The next station on the way to `target`, at most `stride` metres on. The robot faces
    /// `facing` radians off the direction to the target: 0 where it walks there, pi where the way
    /// will be walked from the target to here.
    pub fn toward(&self, target: &Self, stride: f64, facing: f64) -> Self {
        let way = self.way_to(target);
        let length = way.length();
        let heading = if length < FACING_DISTANCE_MIN {
            target.yaw
        } else {
            libm::atan2(way.y, way.x) + facing
        };
        let turn = wrap_angle(heading - self.yaw);
        let walks = length > 0.2 * stride
            && (turn.abs() <= WALKING_DEVIATION_MAX || length < FACING_DISTANCE_MIN);
        let turn_max = if walks { TURN_WALKING_MAX } else { TURN_IN_PLACE_MAX };
        let share = if walks { (stride / length).min(1.0) } else { 0.0 };
        Self {
            position: self.position + (share * way).extend(0.0),
            yaw: self.yaw + turn.clamp(-turn_max, turn_max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn station(x: f64, y: f64, yaw: f64) -> Station {
        Station { position: DVec3::new(x, y, 0.0), yaw }
    }

    #[test]
    fn the_way_to_a_target_ends_at_it() {
        for (yaw, facing) in [(0.0, 0.0), (2.5, 0.0), (-1.0, PI), (0.3, FRAC_PI_2)] {
            let target = station(3.0, 1.0, 0.4);
            let mut at = station(0.0, 0.0, yaw);
            for _ in 0..60 {
                at = at.toward(&target, 0.25, facing);
            }
            assert!(at.distance(&target) < 0.06, "{at:?}");
        }
    }

    #[test]
    fn a_way_that_will_be_walked_from_its_end_is_faced_backward() {
        let (goal, target) = (station(0.0, 0.0, 0.0), station(-3.0, 0.0, 0.0));
        let walked = goal.toward(&target, 0.25, PI);
        assert!(walked.yaw.abs() < 1e-12 && walked.position.x < -0.2);
    }

    #[test]
    fn a_robot_that_faces_aside_steps_sideways() {
        let beside = station(0.0, 0.0, 0.0).toward(&station(0.0, 3.0, 0.0), 0.25, -FRAC_PI_2);
        assert!(beside.yaw.abs() < 1e-12 && (beside.position.y - 0.25).abs() < 1e-12, "{beside:?}");
    }

    #[test]
    fn it_turns_before_it_walks_off_sideways() {
        let turned = station(0.0, 0.0, 0.0).toward(&station(0.0, 3.0, 0.0), 0.25, 0.0);
        assert_eq!(turned.position, DVec3::ZERO);
        assert!((turned.yaw - TURN_IN_PLACE_MAX).abs() < 1e-12);
    }
}
