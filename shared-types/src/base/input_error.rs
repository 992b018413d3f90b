//! Errors in files of the user: robots, worlds, scenarios and plans.

use std::path::{Path, PathBuf};

/// An unusable file: its path, the location in it, the error and how to correct it. A command ends
/// with exit code 2.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct InputError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1, if known.
    pub line: Option<usize>,
    /// The element of the file, such as `joint 'left_knee'`, if it is one.
    pub element: Option<String>,
    /// The error and how to correct it, one line.
    pub message: String,
}

impl std::fmt::Display for InputError {
    /// `<path>[:<line>]: [<element>: ]<message>`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": ")?;
        if let Some(element) = &self.element {
            write!(f, "{element}: ")?;
        }
        write!(f, "{}", self.message)
    }
}

impl InputError {
    /// An error in a file as a whole.
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line: None, element: None, message: message.into() }
    }

    /// An error in one named element of a file.
    pub fn element(path: &Path, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { element: Some(element.into()), ..Self::file(path, message) }
    }

    /// The same error with its line, counted from 1.
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }
}
