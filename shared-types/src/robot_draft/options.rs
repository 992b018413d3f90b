//! What the user decides of a draft.

/// Decisions of the user.
#[derive(Debug, Clone, Default)]
pub struct DraftOptions {
    /// The links of the left and of the right foot.
    pub feet: Option<[String; 2]>,
    /// The bend of the knees that is tried first, rad.
    pub knee_bend: Option<f64>,
    /// Whether links whose mesh files are missing go without these shapes.
    pub skip_missing_meshes: bool,
}
