//! What a plan answers.

use surefoot_shared_types::plan_format::blocks::EndBlock;

use crate::api::robot::Robot;
use crate::api::world::World;

/// The robot, the world, the start and the goal of a plan.
#[derive(Debug, Clone)]
pub(crate) struct PlanInputs {
    /// The robot.
    pub robot: Robot,
    /// The world.
    pub world: World,
    /// The start and the goal, as a plan file states them.
    pub ends: [EndBlock; 2],
}
