//! The two footholds of a transition.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};

use crate::constraints::foothold::Foothold;

/// The footholds of a transition: all weight on `stance`, `other` in contact.
#[derive(Debug, Clone, Copy)]
pub struct TransitionPair<'a> {
    /// The foothold that supports the robot.
    pub stance: &'a Foothold,
    /// The foothold that is touched.
    pub other: &'a Foothold,
}

impl TransitionPair<'_> {
    /// The sole poses, by limb.
    pub fn world_from_soles(self) -> [Pose; 2] {
        let mut soles = [self.other.world_from_sole; 2];
        soles[self.stance.limb] = self.stance.world_from_sole;
        soles
    }

    /// Whether the left foot stands to the right of the right one, in the mean heading of both.
    pub fn is_crossed(self) -> bool {
        let [left, right] = self.world_from_soles();
        let leftward = rotation_about(DVec3::Z, mean_yaw(left.rotation, right.rotation)) * DVec3::Y;
        (left.translation - right.translation).dot(leftward) < 0.0
    }

    /// The mean heading of both soles, rad.
    pub fn heading(self) -> f64 {
        mean_yaw(self.stance.world_from_sole.rotation, self.other.world_from_sole.rotation)
    }
}

/// The mean heading of two rotations, rad.
fn mean_yaw(a: DQuat, b: DQuat) -> f64 {
    let (a, b) = (yaw_of(a), yaw_of(b));
    a + 0.5 * wrap_angle(b - a)
}
