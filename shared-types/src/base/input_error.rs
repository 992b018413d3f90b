//! What is wrong with a file that a user gave us.

use std::path::{Path, PathBuf};

/// A file that cannot be used: which one, where in it, and what to do. Ends a command with exit
/// code 2.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {}{message}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default(), element.as_ref().map(|e| format!("{e}: ")).unwrap_or_default())]
pub struct InputError {
    /// The file at fault.
    pub path: PathBuf,
    /// The line at fault, from 1, where known.
    pub line: Option<usize>,
    /// The element at fault, such as `joint 'left_knee'`, where there is one.
    pub element: Option<String>,
    /// What is wrong and what to do, one line.
    pub message: String,
}

impl InputError {
    /// An error about the whole of a file.
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line: None, element: None, message: message.into() }
    }

    /// An error about one named element of a file.
    pub fn element(path: &Path, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { element: Some(element.into()), ..Self::file(path, message) }
    }

    /// The same error, with the line it stands in.
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }
}
