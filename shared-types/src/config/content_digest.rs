//! The digest of a scenario: of all its fields that change a plan, except the robot and the world,
//! which have digests of their own.

use serde::Serialize;

use crate::base::digest::Digest;
use crate::config::execution::{ExecutionConfig, MotionKind};
use crate::config::planner::{CheckerConfig, PlannerConfig};
use crate::config::scenario::{Scenario, StancePose};

/// One live route does not count: with it a search is that without the parameter.
const ONE_LIVE_ROUTE: &str = r#","live_routes":1"#;

#[derive(Serialize)]
struct Content<'a> {
    seed: u64,
    start: StanceContent,
    goal: StanceContent,
    goal_position_tolerance: f64,
    goal_yaw_tolerance: f64,
    planner: &'a PlannerConfig,
    checker: &'a CheckerConfig,
    execution: &'a ExecutionConfig,
}

#[derive(Serialize)]
struct StanceContent {
    xyz: [f64; 3],
    yaw: f64,
    stance_width: f64,
}

impl From<&StancePose> for StanceContent {
    fn from(stance: &StancePose) -> Self {
        Self { xyz: stance.position.to_array(), yaw: stance.yaw, stance_width: stance.stance_width }
    }
}

impl Scenario {
    /// The same scenario with another seed and the digest of the result.
    pub fn with_seed(self, seed: u64) -> Self {
        let scenario = Self { seed, ..self };
        Self { digest: content_digest(&scenario), ..scenario }
    }

    /// The same scenario with another motion and the digest of the result.
    pub fn with_motion(self, motion: MotionKind) -> Self {
        let execution = ExecutionConfig { motion, ..self.execution };
        let scenario = Self { execution, ..self };
        Self { digest: content_digest(&scenario), ..scenario }
    }
}

/// The digest of a scenario's content. Names and paths do not count.
fn content_digest(scenario: &Scenario) -> Digest {
    let content = Content {
        seed: scenario.seed,
        start: (&scenario.start).into(),
        goal: (&scenario.goal).into(),
        goal_position_tolerance: scenario.goal_tolerance.position,
        goal_yaw_tolerance: scenario.goal_tolerance.yaw,
        planner: &scenario.planner,
        checker: &scenario.checker,
        execution: &scenario.execution,
    };
    let text = serde_json::to_string(&content).expect("a struct of numbers has a JSON form");
    Digest::of(&[text.replace(ONE_LIVE_ROUTE, "").as_bytes()])
}
