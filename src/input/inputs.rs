//! What a run is about: scenario, robot and world.

use std::path::Path;

use surefoot_planner::preparation::build::Preparation;
use surefoot_shared_types::InputError;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;

use crate::input::preparation_cache;
use crate::report::command_error::CommandError;

/// A scenario with all that it names.
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
    /// Loads a scenario, its robot and its world; `seed` takes the place of the scenario's own.
    ///
    /// # Errors
    /// When one of the files cannot be used.
    pub fn load(path: &Path, seed: Option<u64>) -> Result<Self, InputError> {
        let scenario = load_scenario(path)?;
        let scenario = match seed {
            Some(seed) => scenario.with_seed(seed),
            None => scenario,
        };
        let model = load_robot(&scenario.robot_path)?;
        let world = load_world(&scenario.world_path)?;
        Ok(Self { scenario, model, world })
    }

    /// What is prepared for the robot, from the cache or made now; `quiet` shows no progress.
    ///
    /// # Errors
    /// When the robot is none that the planner can move.
    pub fn preparation(&self, quiet: bool) -> Result<Preparation<'static>, CommandError> {
        Ok(preparation_cache::obtain(&self.model, &self.scenario.planner, quiet)?.preparation)
    }
}
