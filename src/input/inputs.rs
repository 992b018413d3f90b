//! The inputs of a run: scenario, robot and world.

use std::path::{Path, PathBuf};

use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::config::scenario_source::ScenarioSource;
use surefoot_shared_types::message::Description;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::scenario::load::scenario_and_robot;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;
use surefoot_shared_types::{InputError, Shape};

use crate::cli::arguments::SearchArguments;
use crate::input::preparation_cache;
use crate::input::shipped::scenario_path;
use crate::report::command_error::CommandError;
use crate::report::run_report::RunNames;
use crate::system::signals::{self, Activity};

/// What the command line sets instead of the scenario file.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overrides {
    /// The seed.
    pub seed: Option<u64>,
    /// The motion.
    pub motion: Option<MotionKind>,
}

/// A scenario with its robot and its world.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The scenario.
    pub scenario: Scenario,
    /// Its robot.
    pub model: RobotModel,
    /// Its world.
    pub world: World,
    /// The scenario's text, if it came from a pipe, which gives it only once.
    pub piped_scenario: Option<String>,
}

impl Overrides {
    /// Those of a search.
    pub fn of(search: &SearchArguments) -> Self {
        Self { seed: search.seed, motion: search.motion }
    }

    fn apply(self, scenario: Scenario) -> Scenario {
        let scenario = match self.seed {
            Some(seed) => scenario.with_seed(seed),
            None => scenario,
        };
        match self.motion {
            Some(motion) => scenario.with_motion(motion),
            None => scenario,
        }
    }
}

impl Inputs {
    /// Loads a scenario, a file or the name of a shipped one, its robot and its world; `overrides`
    /// replace the scenario's values.
    ///
    /// # Errors
    /// One of the files cannot be used.
    pub fn load(path: &Path, overrides: Overrides) -> Result<Self, InputError> {
        signals::set_activity(Activity::Reading);
        let source = ScenarioSource::read(&scenario_path(path)?)?;
        let (scenario, model) = scenario_and_robot(&source)?;
        let scenario = overrides.apply(scenario);
        let world = load_world(&scenario.world_path)?;
        signals::set_activity(Activity::Other);
        let piped_scenario = source.piped_text().map(str::to_owned);
        Ok(Self { scenario, model, world, piped_scenario })
    }

    /// The robot's preparation, from the cache or built now. `quiet` shows no progress.
    ///
    /// # Errors
    /// The planner cannot move the robot.
    pub fn preparation(&self, quiet: bool) -> Result<Preparation, CommandError> {
        Ok(preparation_cache::obtain(&self.model, &self.scenario.planner, quiet)?.preparation)
    }

    /// What readers of an instance have to know of walks with these inputs. `sender` is the
    /// planner's session or the controller's id.
    pub fn description(&self, sender: u64) -> Description {
        Description::of(sender, &self.model, self.world.digest, self.scenario.digest)
    }

    /// The files that were read.
    pub fn files(&self) -> Vec<PathBuf> {
        let meshes = self.world.shapes.iter().filter_map(|shape| match &shape.shape {
            Shape::Mesh { source: Some(source), .. } => Some(source.path.clone()),
            _ => None,
        });
        let scenario = &self.scenario;
        let named = [&scenario.path, &scenario.robot_path, &scenario.world_path];
        let named = named.into_iter().chain([&self.model.urdf_path]).cloned();
        named.chain(meshes).collect()
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
