//! Where a walk begins and ends.

use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::scenario::StancePose;

use crate::api::parameters::Parameters;

/// Lateral distance between the soles where none is set, m.
const WIDTH_DEFAULT: f64 = 0.2;

/// Both soles side by side on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// Midpoint between the two sole frames in the world, m.
    pub position: [f64; 3],
    /// Heading in the world, rad.
    pub yaw: f64,
    /// Lateral distance between the two sole frames, m.
    pub width: f64,
}

impl Stance {
    /// A stance at `x`, `y`, `z` (m) that heads along x, 0.2 m wide.
    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self { position: [x, y, z], yaw: 0.0, width: WIDTH_DEFAULT }
    }

    /// The same stance with a heading, rad.
    #[must_use]
    pub const fn with_yaw(self, yaw: f64) -> Self {
        Self { yaw, ..self }
    }

    /// The same stance with another lateral distance between the soles, m.
    #[must_use]
    pub const fn with_width(self, width: f64) -> Self {
        Self { width, ..self }
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

impl From<Stance> for StancePose {
    fn from(stance: Stance) -> Self {
        Self { position: stance.position.into(), yaw: stance.yaw, stance_width: stance.width }
    }
}

/// The numbers of a scenario from a start to a goal.
pub(crate) fn content(
    start: Stance,
    goal: Goal,
    parameters: &Parameters,
    seed: u64,
) -> ScenarioContent {
    let Parameters { planner, checker, execution } = parameters.clone();
    ScenarioContent {
        start: start.into(),
        goal: goal.stance.into(),
        goal_position_tolerance: goal.position_tolerance,
        goal_yaw_tolerance: goal.yaw_tolerance,
        seed,
        planner,
        checker,
        execution,
    }
}
