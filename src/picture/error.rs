//! Why a picture could not be made.

use std::path::PathBuf;

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file's name says neither still nor moving.
    #[error("{}: the name must end in .png (still) or .apng (animated)", path.display())]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("{}: cannot write the picture: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The plan does not belong to the robot, or contradicts itself.
    #[error("the plan cannot be drawn: {reason}; export it again from the same robot")]
    Plan {
        /// The reason.
        reason: String,
    },
    /// A convex hull without volume.
    #[error(
        "'{name}' cannot be drawn: its convex hull has no volume ({reason}); give it at least four points that span one"
    )]
    Hull {
        /// The shape or link.
        name: String,
        /// What the hull's construction said.
        reason: String,
    },
    /// No link has a collision shape.
    #[error(
        "the robot cannot be drawn: none of its links has a collision shape; add some to its URDF"
    )]
    NoRobotShapes,
}

impl PictureError {
    pub(crate) fn plan(reason: impl Into<String>) -> Self {
        Self::Plan { reason: reason.into() }
    }
}
