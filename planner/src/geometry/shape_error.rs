//! Errors of shapes.

use surefoot_shared_types::Pose;

/// Why a shape cannot be used for collision checks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// The points of a hull do not span a volume.
    #[error(
        "{owner}: the convex hull is degenerate ({reason}); \
         give at least four points that span a volume"
    )]
    DegenerateHull {
        /// Owner of the shape, such as `link 'left_shin', shape 0`.
        owner: String,
        /// The reason.
        reason: String,
    },
    /// A mesh has no triangles, or a triangle refers to a missing vertex.
    #[error("{owner}: the mesh {reason}; repair or remove it")]
    BadMesh {
        /// Owner of the shape.
        owner: String,
        /// The reason.
        reason: String,
    },
    /// A size or a pose is not finite, or a size is not positive.
    #[error("{owner}: {what} must be {requirement}")]
    BadNumber {
        /// Owner of the number.
        owner: String,
        /// Name of the number.
        what: &'static str,
        /// The requirement.
        requirement: &'static str,
    },
}

impl ShapeError {
    /// Requires the pose of `owner` to be finite.
    pub(crate) fn require_finite(pose: &Pose, owner: &str) -> Result<(), Self> {
        pose.is_finite().then_some(()).ok_or_else(|| Self::BadNumber {
            owner: owner.into(),
            what: "the pose",
            requirement: "finite",
        })
    }
}
