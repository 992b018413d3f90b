//! Errors of the collision model.

use crate::geometry::shape_error::ShapeError;

/// Why a collision model cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollisionError {
    /// A shape of the robot or the world cannot be used.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The clearance is not finite, or negative.
    #[error("planner: clearance must be finite and not negative")]
    BadClearance,
    /// The robot has more links with collision shapes than a check's fixed workspace holds.
    #[error(
        "{count} links have collision shapes, {max} are supported; \
         merge links that do not move against each other"
    )]
    TooManyBodies {
        /// Number of links with collision shapes.
        count: usize,
        /// The most supported.
        max: usize,
    },
}
