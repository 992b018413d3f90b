//! The necessary condition C_N at root poses over a mid-feet pose.

use std::f64::consts::FRAC_PI_2;

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_rpy;

use crate::base::random::{Random, Stream};
use crate::constraints::constraints::Constraints;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::preparation::{Preparation, necessary};

/// Root poses over a mid-feet pose that are tested for C_N, the upright one first.
const ROOTS_TRIED_MAX: u64 = 24;
/// Lowest and highest root, relative to that of the standing robot.
const ROOT_HEIGHTS: [f64; 2] = [0.3, 1.1];

/// The root poses over mid-feet poses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RootPoses<'a> {
    /// The robot in the world.
    pub constraints: &'a Constraints,
    /// The reachable spaces.
    pub preparation: &'a Preparation,
    /// The root in the mid-feet frame, the robot upright.
    pub mid_feet_from_root: Pose,
    /// The seed of all random streams.
    pub seed: u64,
}

impl RootPoses<'_> {
    /// Whether C_N holds at a root pose over a mid-feet pose. The poses that are tested follow from
    /// `name`.
    pub fn is_possible(&self, pose: &MidFeetPose, name: u64) -> bool {
        let Constraints { robot, collision, .. } = self.constraints;
        (0..ROOTS_TRIED_MAX).any(|index| {
            let root = self.root_over(pose, (name, index));
            necessary(self.preparation, robot, collision, &root).holds()
        })
    }

    /// A root pose over a mid-feet pose: the upright one, then random ones.
    fn root_over(&self, pose: &MidFeetPose, (name, index): (u64, u64)) -> Pose {
        let mut mid_feet_from_root = self.mid_feet_from_root;
        if index > 0 {
            let mut random = Random::new(self.seed, Stream::Possibility, name | 1 << 61, index);
            let mut within = |half: f64| random.uniform(-half, half);
            let share = within(1.0).abs();
            let [roll, pitch, yaw] = [(); 3].map(|()| share * within(FRAC_PI_2));
            mid_feet_from_root.translation.z *= random.uniform(ROOT_HEIGHTS[0], ROOT_HEIGHTS[1]);
            mid_feet_from_root.rotation *= rotation_from_rpy(roll, pitch, yaw);
        }
        pose.world_from_mid_feet() * mid_feet_from_root
    }
}
