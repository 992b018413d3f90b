//! Regions that stage P avoids because stage M failed there.

use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::tuning::BLOCKED_REGIONS_MAX;

/// A region excluded from sampling.
#[derive(Debug, Clone, Copy)]
struct BlockedRegion {
    center: MidFeetPose,
    /// Radius in the metric of Gamma_P, m.
    radius: f64,
}

/// The regions excluded from sampling.
#[derive(Debug, Clone, Default)]
pub struct BlockedRegions {
    regions: heapless::Deque<BlockedRegion, BLOCKED_REGIONS_MAX>,
}

impl BlockedRegions {
    /// Excludes the region of a radius (m, in the metric of Gamma_P) around a pose.
    pub fn add(&mut self, center: MidFeetPose, radius: f64) {
        if self.regions.is_full() {
            self.regions.pop_front();
        }
        let _full = self.regions.push_back(BlockedRegion { center, radius });
    }

    /// Removes all regions.
    pub fn clear(&mut self) {
        self.regions.clear();
    }

    /// Whether a pose is in one of the regions.
    pub fn contains(&self, pose: &MidFeetPose) -> bool {
        self.regions.iter().any(|region| region.center.distance(pose) < region.radius)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn the_oldest_region_is_dropped_first() {
        let at = |x: usize| MidFeetPose { position: DVec3::new(x as f64, 0.0, 0.0), yaw: 0.0 };
        let mut blocked = BlockedRegions::default();
        (0..=BLOCKED_REGIONS_MAX).for_each(|x| blocked.add(at(x), 0.25));
        assert!(!blocked.contains(&at(0)) && blocked.contains(&at(1)));
        blocked.clear();
        assert!(!blocked.contains(&at(1)));
    }
}
