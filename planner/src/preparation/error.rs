//! Why a robot cannot be prepared, or a preparation cannot be read.

use crate::collision::error::CollisionError;
use crate::kinematics::leg::LegError;
use crate::robot::mechanism::MechanismError;

/// A robot that cannot be prepared.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The planner cannot move the robot.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
    /// A shape of the robot cannot be compiled.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// The preparation that was built cannot be read.
    #[error("the robot's new preparation {0}; please report this with the robot's files")]
    Unsound(#[from] PreparationError),
}

impl From<LegError> for BuildError {
    fn from(error: LegError) -> Self {
        Self::Mechanism(error.into())
    }
}

/// Bytes that are not the expected preparation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PreparationError {
    /// The bytes are no preparation, or one of another version.
    #[error("is no preparation of this version of surefoot; prepare the robot again")]
    Foreign,
    /// The preparation belongs to another robot or other margins.
    #[error("was prepared for another robot or with other margins; prepare the robot again")]
    OtherRobot,
    /// The bytes are incomplete, or changed since they were written.
    #[error("is damaged; prepare the robot again")]
    Damaged,
}
