//! The robot of a scenario as a controller executes chunks on it.

use surefoot_controller_sim::{Checker, ChunkExecutor, Identity};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;

/// The executor of a scenario file for the controller `controller_id`, before its first chunk.
pub fn executor(scenario: &str, controller_id: u64) -> (ChunkExecutor, Identity) {
    let scenario = load_scenario(scenario.as_ref()).unwrap();
    let model = load_robot(&scenario.robot_path).unwrap();
    let world = load_world(&scenario.world_path).unwrap();
    let identity = Identity {
        controller_id,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let checker = Checker::new(model, world, scenario.checker).unwrap();
    (ChunkExecutor::new(checker, identity), identity)
}
