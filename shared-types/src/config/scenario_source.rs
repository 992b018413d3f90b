//! The text of a scenario, read once: from a file, or from a pipe, which gives it only once.

use std::path::{Path, PathBuf};

use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::text_file::{TEXT_BYTES_MAX, TextFile};

/// The name of the standard input on the command line, and its file.
const STANDARD_INPUT: [&str; 2] = ["-", "/dev/stdin"];

/// The text of a scenario.
#[derive(Debug, Clone)]
pub struct ScenarioSource {
    pub(crate) file: TextFile,
    /// The folder that its relative paths refer to: the file's, for a pipe the working folder.
    pub(crate) folder: PathBuf,
    /// Whether it cannot be read a second time.
    is_piped: bool,
}

impl ScenarioSource {
    /// Reads a scenario file, or a pipe to its end. `-` is the standard input.
    ///
    /// # Errors
    /// The file cannot be read or is not text.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let [dash, standard_input] = STANDARD_INPUT.map(Path::new);
        let is_piped = path == dash || is_descriptor(path) || is_pipe(path);
        let opened = if path == dash { standard_input } else { path };
        let file = TextFile::read_any(opened, FileKind::Scenario, TEXT_BYTES_MAX, is_piped)?;
        let folder = path.parent().filter(|_| !is_piped).map(Path::to_owned).unwrap_or_default();
        Ok(Self { file, folder, is_piped })
    }

    /// The text, if it came from a pipe.
    pub fn piped_text(&self) -> Option<&str> {
        self.is_piped.then_some(self.file.text.as_str())
    }
}

fn is_descriptor(path: &Path) -> bool {
    path == Path::new(STANDARD_INPUT[1])
        || ["/dev/fd", "/proc/self/fd"].iter().any(|folder| path.starts_with(folder))
}

fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}
