//! Text files of the user, with the line of each element, so that every error names its line.

use std::borrow::Cow;
use std::io::Read;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::base::closest::{closest, question};
use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;

/// Largest size of a robot, world, scenario or URDF file, bytes.
pub(crate) const TEXT_BYTES_MAX: u64 = 64 << 20;
/// The message about UTF-16 text.
pub(crate) const IS_UTF16: &str = "is UTF-16 text; save it as UTF-8";
/// Largest magnitude of a number in a file, in the number's unit.
pub const NUMBER_MAX: f64 = 1e6;
/// Largest angle that a person writes, rad: a turn, rounded up.
const ANGLE_MAX: f64 = std::f64::consts::TAU + 1e-3;

/// A text file in memory.
#[derive(Debug, Clone)]
pub(crate) struct TextFile {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
}

/// A location in a file, for errors: the path and the line.
#[derive(Debug, Clone)]
pub(crate) struct FileLocation {
    path: PathBuf,
    line: Option<usize>,
}

impl FileLocation {
    /// The location of a file as a whole.
    pub(crate) fn file(path: &Path) -> Self {
        Self { path: path.to_owned(), line: None }
    }

    /// The line; 0 for a file as a whole.
    pub(crate) fn line(&self) -> usize {
        self.line.unwrap_or(0)
    }

    /// An error about `element` at this location.
    pub(crate) fn error(
        &self,
        element: impl Into<String>,
        message: impl Into<String>,
    ) -> InputError {
        InputError {
            line: self.line,
            ..InputError::element(&self.path, element, one_line(&message.into()))
        }
    }
}

impl TextFile {
    /// Reads a whole UTF-8 file of a kind, of at most `bytes_max` bytes.
    pub(crate) fn read(path: &Path, kind: FileKind, bytes_max: u64) -> Result<Self, InputError> {
        Self::read_any(path, kind, bytes_max, false)
    }

    /// As [`Self::read`]; a pipe or a device is read to its end if `is_piped`.
    pub(crate) fn read_any(
        path: &Path,
        kind: FileKind,
        bytes_max: u64,
        is_piped: bool,
    ) -> Result<Self, InputError> {
        let bytes = if is_piped { read_open(path, bytes_max) } else { read_bytes(path, bytes_max) };
        let bytes = bytes.map_err(|message| InputError::file(path, message))?;
        check_text(&bytes).map_err(|message| InputError::file(path, message))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
            let line = line_at(valid, valid.len());
            let refused = InputError::file(path, "is not UTF-8 text").at_line(line);
            kind.needed_instead(path, error.as_bytes(), refused)
        })?;
        Ok(Self { path: path.to_owned(), text })
    }

    /// The location of the byte at `offset`.
    pub(crate) fn location(&self, offset: usize) -> FileLocation {
        FileLocation { path: self.path.clone(), line: Some(self.line(offset)) }
    }

    /// The number of the line that holds the byte at `offset`, from 1.
    pub(crate) fn line(&self, offset: usize) -> usize {
        line_at(self.text.as_bytes(), offset)
    }

    /// The whole text as a TOML document of a kind.
    pub(crate) fn parse_toml<T: DeserializeOwned>(&self, kind: FileKind) -> Result<T, InputError> {
        toml::from_str(&self.text).map_err(|error| {
            let message = with_advice(one_line(error.message()));
            let key = error.span().and_then(|span| key_of(&self.text, &span));
            let message = match key.filter(|_| !names_key(&message)) {
                Some(key) => InputError::element(&self.path, key, message),
                None => InputError::file(&self.path, message),
            };
            let message = match error.span() {
                Some(span) => message.at_line(line_at(self.text.as_bytes(), span.start)),
                None => message,
            };
            kind.needed_instead(&self.path, self.text.as_bytes(), message)
        })
    }
}

/// Whether a message of the TOML reader names the key that it is about.
fn names_key(message: &str) -> bool {
    ["unknown field", "missing field", "duplicate"].iter().any(|what| message.starts_with(what))
}

/// The key of the value at `span` of a TOML document, as `feet[0].polygon`; nothing where the text
/// is no TOML, or nothing stands there.
fn key_of(text: &str, span: &Range<usize>) -> Option<String> {
    key_within(DeTable::parse(text).ok()?.get_ref(), span)
}

fn key_within(table: &DeTable<'_>, span: &Range<usize>) -> Option<String> {
    table
        .iter()
        .find_map(|(name, value)| Some(format!("{}{}", name.get_ref(), path_within(value, span)?)))
}

/// The path from a value to the one at `span` within it, empty if that is the value itself. The
/// span of a table of its own lines is its header.
fn path_within(value: &Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<String> {
    let within = match value.get_ref() {
        DeValue::Table(table) => key_within(table, span).map(|key| format!(".{key}")),
        DeValue::Array(values) => values
            .iter()
            .enumerate()
            .find_map(|(at, value)| path_within(value, span).map(|path| format!("[{at}]{path}"))),
        _ => None,
    };
    let holds = value.span().start <= span.start && span.end <= value.span().end;
    within.or_else(|| holds.then(String::new))
}

/// Refuses bytes that are no text of one byte a letter, or none at all.
fn check_text(bytes: &[u8]) -> Result<(), String> {
    let is_zero = |at: usize| bytes.iter().skip(at).step_by(2).take(8).all(|byte| *byte == 0);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err("is empty; copy or write it again".to_owned());
    }
    // Of Latin letters one byte of two is 0; of the header of a binary file both may be.
    if bytes.len() > 2 && (has_utf16_mark(bytes) || is_zero(0) != is_zero(1)) {
        return Err(IS_UTF16.to_owned());
    }
    Ok(())
}

/// Whether bytes begin as UTF-16 text does: with a byte order mark.
pub(crate) fn has_utf16_mark(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff")
}

/// Reads a regular file of at most `bytes_max` bytes.
pub(crate) fn read_bytes(path: &Path, bytes_max: u64) -> Result<Vec<u8>, String> {
    let found = std::fs::metadata(path)
        .map_err(|error| format!("{}{}", unreadable(&error), question(path)))?;
    if found.is_dir() {
        return Err("is a folder; name a file in it".into());
    }
    if !found.is_file() {
        return Err("is not a regular file".into());
    }
    read_open(path, bytes_max)
}

fn unreadable(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "cannot be read: there is no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => {
            "cannot be read: permission is denied; change its mode".to_owned()
        }
        _ => format!("cannot be read: {error}"),
    }
}

/// Reads what `path` gives until its end, at most `bytes_max` bytes.
fn read_open(path: &Path, bytes_max: u64) -> Result<Vec<u8>, String> {
    let unreadable = |error: std::io::Error| unreadable(&error);
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take(bytes_max + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > bytes_max {
        return Err(format!("is larger than {} MiB", bytes_max >> 20));
    }
    Ok(bytes)
}

/// The absolute path of a file. Symbolic links in the path of its folder are resolved, the file
/// itself is not: paths relative to a file refer to the folder in which it is named.
pub(crate) fn absolute(path: &Path) -> PathBuf {
    let lexical = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match (lexical.parent().and_then(|folder| folder.canonicalize().ok()), lexical.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => lexical,
    }
}

/// The absolute path of a folder, without links and `..` where it exists.
pub fn absolute_folder(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| absolute(path))
}

/// The folder of a file; `.` for a name alone.
pub fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or_else(|| PathBuf::from("."), Path::to_owned)
}

/// The path of a file from a folder, which need not exist yet.
pub fn relative_path(file: &Path, folder: &Path) -> String {
    let folder = folder.canonicalize().unwrap_or_else(|_| absolute(folder));
    relative_to(&absolute(file), &folder)
}

/// The absolute path `target` relative to the absolute path `folder`, with forward slashes.
pub(crate) fn relative_to(target: &Path, folder: &Path) -> String {
    let target: Vec<Component> = target.components().collect();
    let folder: Vec<Component> = folder.components().collect();
    let common = target.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..".to_owned(), folder.len() - common);
    let down = target[common..].iter().map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// The text with every line end as `\n`: some programs end lines with `\r` alone.
pub(crate) fn plain_lines(text: &str) -> Cow<'_, str> {
    match text.contains('\r') {
        true => Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n")),
        false => Cow::Borrowed(text),
    }
}

/// An error unless all numbers are finite and at most [`NUMBER_MAX`] in magnitude.
pub(crate) fn check_numbers(name: &str, numbers: &[f64]) -> Result<(), String> {
    match numbers.iter().find(|number| number.is_nan() || number.abs() > NUMBER_MAX) {
        Some(number) => Err(format!(
            "{name} holds {}; every number must be finite and at most {NUMBER_MAX:e} in magnitude",
            short(*number)
        )),
        None => Ok(()),
    }
}

/// An error unless all numbers are angles in radians of at most one turn. Degrees are more.
///
/// # Errors
/// The message names the angle, and what it is if it was meant in degrees.
pub fn check_angles(name: &str, angles: &[f64]) -> Result<(), String> {
    check_numbers(name, angles)?;
    match angles.iter().find(|angle| angle.abs() > ANGLE_MAX) {
        Some(angle) => Err(format!(
            "{name} holds {angle}, more than one turn; angles are in radians, where {angle} degrees are {:.4}",
            angle.to_radians()
        )),
        None => Ok(()),
    }
}

/// A number with few digits, however large it is.
fn short(number: f64) -> String {
    let is_long = number.is_finite() && number.abs() > 1e3 * NUMBER_MAX;
    if is_long { format!("{number:e}") } else { number.to_string() }
}

/// An error unless all numbers are positive, finite and at most [`NUMBER_MAX`].
pub(crate) fn check_positive(name: &str, numbers: &[f64]) -> Result<(), String> {
    check_each(name, numbers, |number| number > 0.0, "be positive")
}

/// An error unless all numbers are zero or positive, finite and at most [`NUMBER_MAX`].
pub(crate) fn check_not_negative(name: &str, numbers: &[f64]) -> Result<(), String> {
    check_each(name, numbers, |number| number >= 0.0, "not be negative")
}

fn check_each(
    name: &str,
    numbers: &[f64],
    is_valid: fn(f64) -> bool,
    requirement: &str,
) -> Result<(), String> {
    check_numbers(name, numbers)?;
    match numbers.iter().find(|number| !is_valid(**number)) {
        Some(number) => Err(format!("{name} is {number}; it must {requirement}")),
        None => Ok(()),
    }
}

fn line_at(text: &[u8], offset: usize) -> usize {
    1 + text[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// The message with what to do: for an unknown name the one that was probably meant, instead of all
/// that are known; what kind of value is needed; that a missing one is to be stated.
fn with_advice(message: String) -> String {
    if message.starts_with("missing field") {
        return message + "; state it";
    }
    for (of_serde, plain) in [
        ("expected u64", "a whole number is needed, 0 or more"),
        ("expected f64", "a number is needed"),
        ("expected a string", "text in quotes is needed"),
        ("expected a sequence", "a list in brackets is needed"),
    ] {
        if let Some(found) = message.strip_suffix(of_serde) {
            return format!("{}; {plain}", found.trim_end().trim_end_matches(','));
        }
    }
    with_question(message)
}

fn with_question(message: String) -> String {
    let Some((unknown, known)) = message.split_once(", expected ") else { return message };
    let quoted = |text: &str| -> Vec<String> {
        text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let (names, known) = (quoted(unknown), quoted(known));
    let meant = names.first().and_then(|name| closest(name, known.iter().map(String::as_str)));
    match meant {
        Some(meant) if unknown.starts_with("unknown ") => {
            format!("{unknown}; did you mean `{meant}`?")
        }
        _ => message,
    }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
