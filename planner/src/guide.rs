//! The guide route along which foot placements are sought: for now a straight line from start to goal.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::Mark;
use surefoot_shared_types::spatial::{rotation_about, wrap_angle};

/// A straight line between two marks, with stations at even distances.
#[derive(Debug, Clone)]
pub struct Guide {
    start: Mark,
    goal: Mark,
    stations: usize,
}

impl Guide {
    /// The line from `start` to `goal` with stations at most `spacing` (m) apart.
    pub fn new(start: Mark, goal: Mark, spacing: f64) -> Self {
        let length = (goal.position - start.position).truncate().length();
        Self { start, goal, stations: libm::ceil(length / spacing) as usize + 1 }
    }

    /// How many stations there are, both ends included.
    pub fn stations(&self) -> usize {
        self.stations.max(2)
    }

    /// Where a foot would ideally stand at a station: beside the line, facing along it; at both ends as the marks say.
    pub fn world_from_ideal_sole(&self, station: usize, limb: usize) -> Pose {
        let last = self.stations() - 1;
        if station == 0 {
            return self.start.world_from_soles()[limb];
        }
        if station >= last {
            return self.goal.world_from_soles()[limb];
        }
        let share = station as f64 / last as f64;
        let position = self.start.position.lerp(self.goal.position, share);
        let rotation = rotation_about(DVec3::Z, self.heading(share));
        let apart = self.start.feet_apart + share * (self.goal.feet_apart - self.start.feet_apart);
        let side = if limb == 0 { 0.5 } else { -0.5 };
        Pose::from_parts(position + rotation * (DVec3::Y * side * apart), rotation)
    }

    /// Along the line, where it is long enough to have a direction; else turning from one mark's heading to the other's.
    fn heading(&self, share: f64) -> f64 {
        let way = self.goal.position - self.start.position;
        if way.truncate().length() > 0.5 {
            libm::atan2(way.y, way.x)
        } else {
            self.start.yaw + share * wrap_angle(self.goal.yaw - self.start.yaw)
        }
    }
}
