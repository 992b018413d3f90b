//! A scenario: which robot, in which world, from where to where, with what budget.

use crate::config::content_digest;
use std::path::PathBuf;

use glam::DVec3;

use crate::config::planner::CheckerConfig;
use crate::config::planner::PlannerConfig;

use crate::base::digest::Digest;
use crate::base::spatial::Pose;

/// A validated scenario file, its paths resolved.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The file's stem.
    pub name: String,
    /// The scenario file.
    pub path: PathBuf,
    /// The robot file, `robot.toml`.
    pub robot_path: PathBuf,
    /// The world file.
    pub world_path: PathBuf,
    /// Stance at the start.
    pub start: StancePose,
    /// Stance at the goal.
    pub goal: StancePose,
    /// How far a sole's centre may be from its goal pose, m.
    pub goal_position_tolerance: f64,
    /// How far a sole's heading may be from its goal pose, rad.
    pub goal_yaw_tolerance: f64,
    /// The seed of all random streams.
    pub seed: u64,
    /// Everything that bounds or shapes the search.
    pub planner: PlannerConfig,
    /// The checker's tolerances.
    pub checker: CheckerConfig,
    /// Digest of all fields above that influence a plan.
    pub digest: Digest,
}

impl Scenario {
    /// The same scenario with another seed, and the digest that goes with it.
    pub fn with_seed(self, seed: u64) -> Self {
        let scenario = Self { seed, ..self };
        Self { digest: content_digest::digest(&scenario), ..scenario }
    }
}

/// Both soles side by side, heading along `yaw`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StancePose {
    /// The middle between the two sole frames, on the ground, m.
    pub position: DVec3,
    /// The heading, rad.
    pub yaw: f64,
    /// The distance between the two sole frames, m.
    pub stance_width: f64,
}

impl StancePose {
    /// The sole frames of the left and the right foot in the world.
    pub fn world_from_soles(&self) -> [Pose; 2] {
        let rotation = crate::base::spatial::rotation_about(DVec3::Z, self.yaw);
        [0.5, -0.5].map(|side| {
            Pose::from_parts(
                self.position + rotation * (DVec3::Y * side * self.stance_width),
                rotation,
            )
        })
    }
}
