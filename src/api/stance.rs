//! Where a walk begins and ends.

use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::scenario::StancePose;

use crate::api::parameters::Parameters;
use crate::api::robot::Robot;

/// Both soles side by side on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// Midpoint between the two sole frames in the world, m.
    pub position: [f64; 3],
    /// Heading in the world, rad.
    pub yaw: f64,
    /// Lateral distance between the two sole frames, m; `None`: that of the robot as it stands.
    pub width: Option<f64>,
}

impl Stance {
    /// A stance at `x`, `y`, `z` (m) that heads along x, as wide as the robot stands.
    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self { position: [x, y, z], yaw: 0.0, width: None }
    }

    /// The same stance with a heading, rad.
    #[must_use]
    pub const fn with_yaw(self, yaw: f64) -> Self {
        Self { yaw, ..self }
    }

    /// The same stance with another lateral distance between the soles, m.
    #[must_use]
    pub const fn with_width(self, width: f64) -> Self {
        Self { width: Some(width), ..self }
    }

    /// The stance of a robot.
    pub fn pose(self, robot: &Robot) -> StancePose {
        let stance_width = self.width.unwrap_or_else(|| robot.model().stance_width());
        StancePose { position: self.position.into(), yaw: self.yaw, stance_width }
    }
}

/// A stance to reach, with tolerances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// The stance.
    pub stance: Stance,
    /// How far each sole's centre may be from its place, m.
    pub position_tolerance: f64,
    /// How far each sole's heading may be off, rad.
    pub yaw_tolerance: f64,
}

impl Goal {
    /// A goal at `x`, `y`, `z` (m) that heads along x, with the tolerances of a scenario file:
    /// 0.1 m and 0.35 rad.
    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self { stance: Stance::at(x, y, z), position_tolerance: 0.10, yaw_tolerance: 0.35 }
    }

    /// The same goal with a heading, rad.
    #[must_use]
    pub const fn with_yaw(self, yaw: f64) -> Self {
        Self { stance: self.stance.with_yaw(yaw), ..self }
    }

    /// The same goal with other tolerances, m and rad.
    #[must_use]
    pub const fn with_tolerances(self, position: f64, yaw: f64) -> Self {
        Self { position_tolerance: position, yaw_tolerance: yaw, ..self }
    }
}

/// The numbers of a robot's scenario from a start to a goal.
pub(crate) fn content(
    robot: &Robot,
    start: Stance,
    goal: Goal,
    parameters: &Parameters,
    seed: u64,
) -> ScenarioContent {
    let Parameters { planner, checker, execution } = parameters.clone();
    ScenarioContent {
        start: start.pose(robot),
        goal: goal.stance.pose(robot),
        goal_position_tolerance: goal.position_tolerance,
        goal_yaw_tolerance: goal.yaw_tolerance,
        seed,
        planner,
        checker,
        execution,
    }
}
