//! A scenario: robot, world, start, goal, seed and parameters of one planning problem.

use std::path::PathBuf;

use glam::DVec3;

use crate::base::digest::Digest;
use crate::base::spatial::{Pose, rotation_about};
use crate::config::execution::ExecutionConfig;
use crate::config::planner::{CheckerConfig, PlannerConfig};

/// Longest way from start to goal, m: a kilometre of level floor takes an hour of walking. Goals in
/// millimetres are farther away.
const WALK_LENGTH_MAX: f64 = 1000.0;

/// A validated scenario. Its paths are resolved against the scenario file's folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Its name: the stem of the scenario file's name.
    pub name: String,
    /// The scenario file.
    pub path: PathBuf,
    /// The robot file (`robot.toml`).
    pub robot_path: PathBuf,
    /// The world file.
    pub world_path: PathBuf,
    /// Stance at the start.
    pub start: StancePose,
    /// Stance at the goal.
    pub goal: StancePose,
    /// How far the soles may be from their goal poses.
    pub goal_tolerance: GoalTolerance,
    /// The seed of all random streams.
    pub seed: u64,
    /// The planner's parameters.
    pub planner: PlannerConfig,
    /// The checker's tolerances.
    pub checker: CheckerConfig,
    /// The parameters of the motion.
    pub execution: ExecutionConfig,
    /// Digest of all fields above that change a plan; not of names and paths.
    pub digest: Digest,
}

/// How far the soles may be from their goal poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GoalTolerance {
    /// Largest distance of a sole frame from its goal pose, m.
    pub position: f64,
    /// Largest heading error of a sole at the goal, rad.
    pub yaw: f64,
}

/// A stance: both soles side by side on level ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StancePose {
    /// Midpoint of the two sole frames in the world, m.
    pub position: DVec3,
    /// Heading about the world's z axis, rad.
    pub yaw: f64,
    /// Lateral distance between the two sole frames, m.
    pub stance_width: f64,
}

impl StancePose {
    /// The poses of the left and the right sole frame in the world.
    pub fn world_from_soles(&self) -> [Pose; 2] {
        let rotation = rotation_about(DVec3::Z, self.yaw);
        [0.5, -0.5].map(|side| {
            Pose::from_parts(
                self.position + rotation * (DVec3::Y * side * self.stance_width),
                rotation,
            )
        })
    }

    /// Whether this start and the goal of a walk are as near to each other as metres make likely.
    ///
    /// # Errors
    /// The goal is more than a kilometre away.
    pub fn check_walk_to(&self, goal: &Self) -> Result<(), String> {
        let length = self.position.distance(goal.position);
        if length <= WALK_LENGTH_MAX {
            return Ok(());
        }
        Err(format!(
            "it is {length:.0} m from the start: millimetres? positions are in m; at most \
             {WALK_LENGTH_MAX} m are possible"
        ))
    }
}
