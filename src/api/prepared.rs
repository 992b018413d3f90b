//! The preparation of a robot: made once for a robot and a set of margins.

use std::io::{Read, Write};
use std::path::Path;

use surefoot_planner::preparation::{Preparation, key, prepare};
use surefoot_shared_types::base::whole_file;

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

    /// Reads the preparation of a robot from a folder, or makes it and saves it there for the next
    /// time. A damaged file is made anew. Several processes may do so at once.
    ///
    /// # Errors
    /// The planner cannot move this robot, or the folder cannot be written to.
    pub fn in_folder(
        robot: &Robot,
        parameters: &Parameters,
        folder: impl AsRef<Path>,
    ) -> Result<Self, PrepareError> {
        let key = key(robot.model(), &parameters.planner);
        let path = folder.as_ref().join(format!("{key}.prepared"));
        let is_file = std::fs::symlink_metadata(&path).is_ok_and(|found| found.is_file());
        if is_file
            && let Ok(file) = std::fs::File::open(&path)
            && let Ok(prepared) = Self::read(robot, parameters, file)
        {
            return Ok(prepared);
        }
        let prepared = Self::new(robot, parameters)?;
        std::fs::create_dir_all(folder.as_ref()).map_err(PrepareError::Save)?;
        whole_file::write(&path, prepared.preparation.bytes())
            .map_err(|reason| PrepareError::Save(std::io::Error::other(reason)))?;
        Ok(prepared)
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
