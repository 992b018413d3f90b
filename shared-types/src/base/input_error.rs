//! Errors in files of the user: robots, worlds, scenarios and plans.

use std::path::{Path, PathBuf};

/// Most complaints that are shown at once.
const SHOWN_MAX: usize = 60;
/// Further errors of one message that make it be shown once.
const EQUAL_MIN: usize = 3;

/// An unusable file: its path, the location in it, the error and how to correct it. A command ends
/// with exit code 2.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1, if known.
    pub line: Option<usize>,
    /// The element of the file, such as `joint 'left_knee'`, if it is one.
    pub element: Option<String>,
    /// The error and how to correct it, one line.
    pub message: String,
    /// What else is wrong, in the order of lines; shown after it, each in its own line.
    pub others: Vec<InputError>,
}

impl InputError {
    /// An error in a file as a whole.
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        let (line, element, others) = (None, None, Vec::new());
        Self { path: path.to_owned(), line, element, message: message.into(), others }
    }

    /// An error in one named element of a file.
    pub fn element(path: &Path, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { element: Some(element.into()), ..Self::file(path, message) }
    }

    /// The same error with its line, counted from 1.
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }

    /// One error of many, in the order of files and lines. A message that many elements share is
    /// shown once.
    ///
    /// # Errors
    /// When there are any.
    pub(crate) fn all(mut errors: Vec<Self>) -> Result<(), Self> {
        errors.sort_by(|a, b| (&a.path, a.line).cmp(&(&b.path, b.line)));
        errors.dedup();
        let errors = Self::merge_equal(errors);
        let mut errors = errors.into_iter();
        match errors.next() {
            Some(first) => Err(Self { others: errors.collect(), ..first }),
            None => Ok(()),
        }
    }

    /// One error for each message that many elements of a file share, with all its lines.
    fn merge_equal(mut errors: Vec<Self>) -> Vec<Self> {
        let mut merged = Vec::new();
        while !errors.is_empty() {
            let first = errors.remove(0);
            let is_same =
                |other: &Self| (&other.path, &other.message) == (&first.path, &first.message);
            let lines: Vec<String> = errors
                .iter()
                .filter(|other| is_same(other))
                .filter_map(|other| other.line.map(|line| line.to_string()))
                .collect();
            if lines.len() < EQUAL_MIN {
                merged.push(first);
                continue;
            }
            errors.retain(|other| !is_same(other));
            let message = format!("{} (the same in lines {})", first.message, lines.join(", "));
            merged.push(Self { message, ..first });
        }
        merged
    }

    fn write_line(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        let element = self.element.iter().map(|element| format!("{element}: "));
        // A file may hold what a terminal would obey.
        let text = element.collect::<String>() + &self.message;
        write!(f, ": {}", text.replace(char::is_control, "\u{fffd}"))
    }
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.write_line(f)?;
        for other in self.others.iter().take(SHOWN_MAX) {
            write!(f, "\nerror: ")?;
            other.write_line(f)?;
        }
        match self.others.len().saturating_sub(SHOWN_MAX) {
            0 => Ok(()),
            more => write!(f, "\nerror: {}: {more} more complaints", self.path.display()),
        }
    }
}

impl std::error::Error for InputError {}
