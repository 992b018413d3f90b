//! The folder of the files that a later run finds again.

use std::path::PathBuf;

/// Why there is no such folder, and what to do.
pub const NO_CACHE_FOLDER: &str = "neither XDG_CACHE_HOME nor HOME names an absolute folder";

/// `surefoot` in the user's cache folder, as the XDG base directory specification names it; `None`
/// where there is none.
pub fn cache_folder() -> Option<PathBuf> {
    let absolute = |path: PathBuf| path.is_absolute().then_some(path);
    let named = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).and_then(absolute);
    let home = std::env::var_os("HOME")
        .map(PathBuf::from)
        .and_then(absolute)
        .map(|home| home.join(".cache"));
    named.or(home).map(|folder| folder.join("surefoot"))
}
