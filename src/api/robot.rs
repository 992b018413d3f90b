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
        Ok(Self::new(load_robot(path.as_ref())?))
    }

    /// The name in the URDF.
    pub fn name(&self) -> &str {
        &self.model.name
    }

    /// The mass of all links, kg.
    pub fn mass(&self) -> f64 {
        self.model.mass()
    }

    /// The names of the moving joints, in the order of [`State::q`](crate::State::q) and of every
    /// waypoint.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.model.joints.iter().map(|joint| joint.name.as_str())
    }

    /// Wraps a validated model.
    pub(crate) fn new(model: RobotModel) -> Self {
        Self { model: Arc::new(model) }
    }

    /// The validated model, for the crates of this repository.
    #[doc(hidden)]
    pub fn model(&self) -> &RobotModel {
        &self.model
    }
}
