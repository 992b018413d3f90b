//! Why a collision model cannot be built.

/// What is wrong with the shapes or settings that a [`crate::collision::model::CollisionModel`] was
/// asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollisionError {
    /// The points of a hull do not span a volume.
    #[error(
        "{owner}: the convex hull is degenerate ({reason}); give at least four points that span a volume"
    )]
    DegenerateHull {
        /// Whose shape it is, such as `link 'left_shin', shape 0`.
        owner: String,
        /// What the hull builder met.
        reason: String,
    },
    /// A mesh without triangles, or one that points outside of its vertices.
    #[error("{owner}: the mesh {reason}; repair or remove it")]
    BadMesh {
        /// Whose shape it is.
        owner: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A size or a pose that is not finite, or a size that is not positive.
    #[error("{owner}: {what} must be {requirement}")]
    BadNumber {
        /// Whose number it is.
        owner: String,
        /// Which number.
        what: &'static str,
        /// What it must be.
        requirement: &'static str,
    },
    /// More links with collision shapes than a check's fixed workspace holds.
    #[error(
        "{count} links have collision shapes, {max} are supported; merge links that do not move against each other"
    )]
    TooManyBodies {
        /// How many there are.
        count: usize,
        /// How many fit.
        max: usize,
    },
}
