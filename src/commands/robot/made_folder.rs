//! A folder that is removed again unless something is written to it.

use std::path::{Path, PathBuf};

use crate::report::command_error::CommandError;

/// The folders that were made, the innermost first; removed when dropped.
#[derive(Debug)]
pub(crate) struct MadeFolder {
    made: Vec<PathBuf>,
}

impl MadeFolder {
    /// Makes a folder and those above it that do not exist.
    ///
    /// # Errors
    /// It cannot be made.
    pub(crate) fn new(folder: &Path) -> Result<Self, CommandError> {
        let is_missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let missing = folder.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        let made = Self { made: missing };
        std::fs::create_dir_all(folder).map_err(|error| CommandError::Output {
            path: folder.to_owned(),
            reason: format!("{error}; choose another folder with --out"),
        })?;
        Ok(made)
    }

    /// Leaves the folders.
    pub(crate) fn keep(&mut self) {
        self.made.clear();
    }
}

impl Drop for MadeFolder {
    fn drop(&mut self) {
        // A folder that another program has written to stays.
        self.made.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_removed_unless_kept() {
        let base = std::env::temp_dir().join(format!("surefoot-made-{}", std::process::id()));
        let inner = base.join("a/b");
        drop(MadeFolder::new(&inner).unwrap());
        assert!(!base.exists());
        MadeFolder::new(&inner).unwrap().keep();
        assert!(inner.is_dir());
        std::fs::remove_dir_all(&base).unwrap();
    }
}
