//! The inputs of a run: scenario, robot and world.

use std::path::Path;

use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::InputError;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;

use crate::input::preparation_cache;
use crate::input::shipped::scenario_path;
use crate::report::command_error::CommandError;
use crate::report::run_report::RunNames;

/// A scenario with its robot and its world.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The scenario.
    pub scenario: Scenario,
    /// Its robot.
    pub model: RobotModel,
    /// Its world.
    pub world: World,
}

impl Inputs {
    /// Loads a scenario, a file or the name of a shipped one, its robot and its world; `seed`
    /// replaces the scenario's.
    ///
    /// # Errors
    /// One of the files cannot be used.
    pub fn load(path: &Path, seed: Option<u64>) -> Result<Self, InputError> {
        let scenario = load_scenario(&scenario_path(path)?)?;
        let scenario = match seed {
            Some(seed) => scenario.with_seed(seed),
            None => scenario,
        };
        let model = load_robot(&scenario.robot_path)?;
        let world = load_world(&scenario.world_path)?;
        Ok(Self { scenario, model, world })
    }

    /// The robot's preparation, from the cache or built now. `quiet` shows no progress.
    ///
    /// # Errors
    /// The planner cannot move the robot.
    pub fn preparation(&self, quiet: bool) -> Result<Preparation, CommandError> {
        Ok(preparation_cache::obtain(&self.model, &self.scenario.planner, quiet)?.preparation)
    }

    /// The names of the inputs in reports.
    pub fn names(&self) -> RunNames {
        let world = self.scenario.world_path.file_stem();
        RunNames {
            scenario: self.scenario.name.clone(),
            robot: self.model.name.clone(),
            world: world.map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
            seed: self.scenario.seed,
        }
    }
}
