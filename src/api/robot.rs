//! A robot.

use std::path::Path;
use std::sync::Arc;

use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;

use crate::api::error::LoadError;

/// A validated biped: what its URDF and the `robot.toml` beside it say. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Robot {
    model: Arc<RobotModel>,
}

impl Robot {
    /// Loads a robot file (`robot.toml`), which names the URDF, the feet with their soles, and the
    /// standing posture. `configs/robots/README.md` explains each line.
    ///
    /// # Errors
    /// A file cannot be read, or something in it is out of order: file, line and element are named.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(Self { model: Arc::new(load_robot(path.as_ref())?) })
    }

    /// The name in the URDF.
    pub fn name(&self) -> &str {
        &self.model.name
    }

    /// The names of the moving joints, in the order of [`State::q`](crate::State::q) and of every
    /// waypoint.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.model.joints.iter().map(|joint| joint.name.as_str())
    }

    /// The validated model.
    pub(crate) fn model(&self) -> &RobotModel {
        &self.model
    }
}
