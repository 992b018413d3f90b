//! The necessary condition C_N at root poses near a mid-feet pose.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_rpy;

use crate::base::random::{Random, Stream};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::vertex_candidates::StageContext;
use crate::preparation::necessary;

/// Root poses near a mid-feet pose that are tested for C_N, the upright one first.
const ROOTS_TRIED_MAX: u64 = 24;
/// Half range of the root's position over the mid-feet pose along x and y, m.
const ROOT_SHIFT: f64 = 0.2;
/// Lowest and highest root, relative to that of the standing robot.
const ROOT_HEIGHTS: [f64; 2] = [0.3, 1.1];

impl StageContext<'_> {
    /// Whether C_N holds at a root pose near a mid-feet pose. The poses that are tested follow from
    /// `name`.
    pub fn is_possible(&self, pose: &MidFeetPose, name: u64) -> bool {
        (0..ROOTS_TRIED_MAX).any(|index| {
            let root = self.root_near(pose, (name, index));
            let collision = &self.constraints.collision;
            necessary(self.preparation, &self.constraints.robot, collision, &root).holds()
        })
    }

    /// A root pose near a mid-feet pose: the upright one, then random ones.
    fn root_near(&self, pose: &MidFeetPose, (name, index): (u64, u64)) -> Pose {
        let mut mid_feet_from_root = self.upper_body.mid_feet_from_root();
        if index > 0 {
            let mut random = Random::new(self.seed, Stream::Possibility, name | 1 << 61, index);
            let mut within = |half: f64| random.uniform(-half, half);
            let shift = DVec3::new(within(ROOT_SHIFT), within(ROOT_SHIFT), 0.0);
            let share = within(1.0).abs();
            let [roll, pitch, yaw] = [(); 3].map(|()| share * within(FRAC_PI_2));
            mid_feet_from_root.translation.z *= random.uniform(ROOT_HEIGHTS[0], ROOT_HEIGHTS[1]);
            mid_feet_from_root.translation += shift;
            mid_feet_from_root.rotation *= rotation_from_rpy(roll, pitch, yaw);
        }
        pose.world_from_mid_feet() * mid_feet_from_root
    }
}
