//! Read-only data of a search.

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::Surfaces;
use crate::preparation::data::Preparation;

/// What every stage reads and none changes: robot, world, preparation, threads, seed.
#[derive(Debug)]
pub struct PlanningContext {
    /// The robot, the world's geometry and the conditions of every configuration.
    pub constraints: Constraints,
    /// The surfaces on which soles can rest.
    pub surfaces: Surfaces,
    /// The preparation of the robot.
    pub preparation: Preparation,
    /// The threads that share the work.
    pub threads: Threads,
    /// The seed of all random streams.
    pub seed: u64,
}
