//! States of a mode.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::robot::configuration::Configuration;

/// A configuration with the poses of its soles: the coordinates in which a mode is searched.
#[derive(Debug, Clone, Copy)]
pub struct ModeState {
    /// Root pose and joint positions.
    pub configuration: Configuration,
    /// Poses of both soles in the world, by limb.
    pub world_from_soles: [Pose; 2],
}

impl Default for ModeState {
    /// The state at the origin, which fills unused memory.
    fn default() -> Self {
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        Self { configuration, world_from_soles: [Pose::IDENTITY; 2] }
    }
}
