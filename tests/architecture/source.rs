//! Source files as text, with paths relative to the repository.

use std::path::Path;

/// One text file.
pub struct Source {
    /// Path from the repository's root, with forward slashes.
    pub path: String,
    /// Its content.
    pub text: String,
}

/// The repository's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files at or below `path` (relative to the root) with one of the extensions, sorted.
pub fn read_tree(path: &str, extensions: &[&str]) -> Vec<Source> {
    let mut found = vec![];
    collect(&root().join(path), extensions, &mut found);
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

fn collect(path: &Path, extensions: &[&str], found: &mut Vec<Source>) {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).unwrap() {
            collect(&entry.unwrap().path(), extensions, found);
        }
        return;
    }
    let is_wanted =
        path.extension().is_some_and(|have| extensions.iter().any(|want| have == *want));
    if is_wanted && path.is_file() {
        let shown = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        found.push(Source { path: shown, text: std::fs::read_to_string(path).unwrap() });
    }
}
