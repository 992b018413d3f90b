//! The preparation of a robot: made once for a robot and a set of margins.

use std::io::{Read, Write};

use surefoot_planner::preparation::{Preparation, key, prepare};

use crate::api::error::PrepareError;
use crate::api::parameters::Parameters;
use crate::api::robot::Robot;

/// The reachable space of each leg, the primitive steps with their range, and the geometry that
/// encloses them [Grey 4.1.1, 4.2.1, 4.4.5]. Making it takes a second or more; keep it in a file
/// with [`Prepared::write`]. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Prepared {
    robot: Robot,
    preparation: Preparation,
}

impl Prepared {
    /// Prepares a robot for the margins in `parameters.planner`, with all cores.
    ///
    /// # Errors
    /// The planner cannot move this robot.
    pub fn new(robot: &Robot, parameters: &Parameters) -> Result<Self, PrepareError> {
        let preparation = prepare(robot.model(), &parameters.planner)?;
        Ok(Self { robot: robot.clone(), preparation })
    }

    /// Reads what [`Prepared::write`] wrote.
    ///
    /// # Errors
    /// Reading fails, or the bytes are damaged or those of another robot or of other margins.
    pub fn read(
        robot: &Robot,
        parameters: &Parameters,
        mut from: impl Read,
    ) -> Result<Self, PrepareError> {
        let mut bytes = vec![];
        from.read_to_end(&mut bytes)?;
        let key = key(robot.model(), &parameters.planner);
        let preparation = Preparation::from_bytes(&bytes, &key)?;
        Ok(Self { robot: robot.clone(), preparation })
    }

    /// Writes all of it.
    ///
    /// # Errors
    /// Writing fails.
    pub fn write(&self, mut to: impl Write) -> std::io::Result<()> {
        to.write_all(self.preparation.bytes())
    }

    /// The robot that it was made for.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The prepared data.
    pub(crate) fn preparation(&self) -> &Preparation {
        &self.preparation
    }
}
