//! Scenarios that no file holds.

use std::path::PathBuf;

use crate::base::digest::Digest;
use crate::base::text_file::{check_angles, check_numbers, check_positive};
use crate::config::execution::ExecutionConfig;
use crate::config::planner::{CheckerConfig, PlannerConfig};
use crate::config::scenario::{GoalTolerance, Scenario, StancePose};
use crate::config::validation::check_relations;

/// A parameter that is out of range, or at odds with another one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{parameter}: {problem}")]
pub struct ScenarioError {
    /// The name of the parameter, as in a scenario file.
    pub parameter: String,
    /// The error, and the valid values.
    pub problem: String,
}

/// Everything of a scenario that influences a plan, apart from robot and world.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioContent {
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
    /// The parameters of the motion.
    pub execution: ExecutionConfig,
}

impl ScenarioContent {
    /// The scenario, with the rules of a scenario file. Its name and its paths are empty. Its
    /// digest is that of a file with the same content.
    ///
    /// # Errors
    /// A number is out of range, the goal is more than a kilometre away, or a planner margin is not
    /// strictly stronger than what the checker tolerates.
    pub fn build(self) -> Result<Scenario, ScenarioError> {
        check_stance("start", &self.start)?;
        check_stance("goal", &self.goal)?;
        self.start.check_walk_to(&self.goal).map_err(|problem| error("goal", problem))?;
        for (parameter, value) in [
            ("goal.position_tolerance", self.goal_position_tolerance),
            ("goal.yaw_tolerance", self.goal_yaw_tolerance),
        ] {
            check_positive("it", &[value]).map_err(|problem| error(parameter, problem))?;
        }
        check_relations(&self.planner, &self.checker, &self.execution)
            .map_err(|(parameter, problem)| ScenarioError { parameter, problem })?;
        let scenario = Scenario {
            name: String::new(),
            path: PathBuf::new(),
            robot_path: PathBuf::new(),
            world_path: PathBuf::new(),
            start: self.start,
            goal: self.goal,
            goal_tolerance: GoalTolerance {
                position: self.goal_position_tolerance,
                yaw: self.goal_yaw_tolerance,
            },
            seed: self.seed,
            planner: self.planner,
            checker: self.checker,
            execution: self.execution,
            digest: Digest::default(),
        };
        Ok(scenario.with_seed(self.seed))
    }
}

fn check_stance(name: &str, stance: &StancePose) -> Result<(), ScenarioError> {
    check_numbers("position", &stance.position.to_array())
        .and_then(|()| check_angles("yaw", &[stance.yaw]))
        .and_then(|()| check_positive("width", &[stance.stance_width]))
        .map_err(|problem| error(name, problem))
}

fn error(parameter: &str, problem: String) -> ScenarioError {
    ScenarioError { parameter: parameter.to_owned(), problem }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn content() -> ScenarioContent {
        let stance = StancePose { position: DVec3::ZERO, yaw: 0.0, stance_width: 0.2 };
        ScenarioContent {
            start: stance,
            goal: stance,
            goal_position_tolerance: 0.1,
            goal_yaw_tolerance: 0.35,
            seed: 1,
            planner: PlannerConfig::default(),
            checker: CheckerConfig::default(),
            execution: ExecutionConfig::default(),
        }
    }

    #[test]
    fn defaults_are_accepted_and_the_seed_changes_the_digest() {
        let one = content().build().unwrap();
        let two = ScenarioContent { seed: 2, ..content() }.build().unwrap();
        assert_ne!(one.digest, two.digest);
    }

    #[test]
    fn the_first_bad_number_is_named() {
        let nowhere = StancePose { position: DVec3::NAN, ..content().start };
        let error = ScenarioContent { goal: nowhere, ..content() }.build().unwrap_err();
        assert_eq!(error.parameter, "goal");
        let far = StancePose { position: DVec3::X * 3000.0, ..content().start };
        let error = ScenarioContent { goal: far, ..content() }.build().unwrap_err();
        assert!(error.to_string().starts_with("goal: it is 3000 m from the start: millimetres?"));
        let turned = StancePose { yaw: 90.0, ..content().goal };
        let error = ScenarioContent { goal: turned, ..content() }.build().unwrap_err();
        let degrees = "goal: yaw holds 90, more than one turn; angles are in radians";
        assert!(error.to_string().starts_with(degrees), "{error}");
        let planner = PlannerConfig { com_margin: -1.0, ..PlannerConfig::default() };
        let error = ScenarioContent { planner, ..content() }.build().unwrap_err();
        assert_eq!(error.parameter, "planner.com_margin");
    }
}
