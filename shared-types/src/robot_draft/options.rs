//! What the user decides of a draft.

use std::collections::BTreeMap;
use std::path::PathBuf;

/// Decisions of the user.
#[derive(Debug, Clone, Default)]
pub struct DraftOptions {
    /// The links of the left and of the right foot.
    pub feet: Option<[String; 2]>,
    /// The bend of the knees that is tried first, rad.
    pub knee_bend: Option<f64>,
    /// Whether links whose mesh files are missing go without these shapes.
    pub skip_missing_meshes: bool,
    /// Folders of packages that cannot be found near the URDF, by name.
    pub packages: BTreeMap<String, PathBuf>,
}
