//! What all stages read and none changes.

use crate::base::threads::Threads;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::Surfaces;
use crate::preparation::build::Preparation;

/// What all stages read.
#[derive(Debug)]
pub struct Shared {
    /// The robot, the world's geometry and the conditions of every configuration.
    pub constraints: Constraints,
    /// Where soles can rest.
    pub surfaces: Surfaces,
    /// What was made once for the robot.
    pub preparation: Preparation<'static>,
    /// The threads that share the work.
    pub threads: Threads,
    /// The seed of all streams.
    pub seed: u64,
}
