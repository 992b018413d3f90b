//! The robots, worlds and scenarios that the program carries, so that it works from any folder.
//!
//! The files of `configs/` are part of the program (`build.rs`). A scenario is named without a path
//! and an extension; its files are then written to the user's cache folder and read from there.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use surefoot_shared_types::InputError;
use surefoot_shared_types::robot_draft::text::ROBOT_FILE;

use crate::input::cache_file;
use crate::input::cache_folder::{NO_CACHE_FOLDER, cache_folder};

/// Every file: its path below `configs/` and its bytes.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/shipped_files.rs"));

/// Least likeness of two names, from 0 to 1, for one to be proposed instead of the other.
const LIKENESS_MIN: f64 = 0.7;

/// A kind of shipped input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShippedKind {
    /// Robot, world, start and goal.
    Scenario,
    /// A robot.
    Robot,
    /// A world.
    World,
}

/// A shipped input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShippedInput {
    /// Its kind.
    pub kind: ShippedKind,
    /// Its name.
    pub name: &'static str,
    /// Its file, below `configs/`.
    pub path: &'static str,
    /// The first sentence of its file, a comment.
    pub summary: String,
}

/// All shipped inputs of a kind, by name.
pub fn shipped(kind: ShippedKind) -> impl Iterator<Item = ShippedInput> {
    FILES.iter().filter_map(move |(path, bytes)| {
        let name = name_of(kind, path)?;
        let summary = first_sentence(std::str::from_utf8(bytes).unwrap_or_default());
        Some(ShippedInput { kind, name, path, summary })
    })
}

/// The first sentence of the comment that a file begins with.
fn first_sentence(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    let comment = lines.collect::<Vec<_>>().join(" ");
    comment.find(". ").map_or(comment.clone(), |end| comment[..=end].to_owned())
}

/// The name under which a file is a shipped input of this kind.
fn name_of(kind: ShippedKind, path: &'static str) -> Option<&'static str> {
    match kind {
        ShippedKind::Scenario => path.strip_prefix("scenarios/")?.strip_suffix(".toml"),
        ShippedKind::World => path.strip_prefix("worlds/")?.strip_suffix(".toml"),
        ShippedKind::Robot => path.strip_prefix("robots/")?.strip_suffix("/robot.toml"),
    }
}

/// The bytes of a shipped file, by its path below `configs/`.
pub fn bytes_of(path: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, bytes)| *bytes)
}

/// The file that a scenario argument means: the argument itself, or the shipped scenario of that
/// name where there is no such file.
///
/// # Errors
/// There is neither, or the shipped files cannot be written to the cache folder.
pub fn scenario_path(argument: &Path) -> Result<PathBuf, InputError> {
    input_path(ShippedKind::Scenario, argument)
}

/// The robot file that an argument means: the argument itself, the one in the folder of that name,
/// or a shipped robot's.
///
/// # Errors
/// As [`scenario_path`].
pub fn robot_path(argument: &Path) -> Result<PathBuf, InputError> {
    let in_folder = argument.join(ROBOT_FILE);
    if in_folder.is_file() {
        return Ok(in_folder);
    }
    input_path(ShippedKind::Robot, argument)
}

/// The world file that an argument means: the argument itself, or a shipped world's.
///
/// # Errors
/// As [`scenario_path`].
pub fn world_path(argument: &Path) -> Result<PathBuf, InputError> {
    input_path(ShippedKind::World, argument)
}

/// As [`scenario_path`], for an input of any kind.
///
/// # Errors
/// As [`scenario_path`].
pub fn input_path(kind: ShippedKind, argument: &Path) -> Result<PathBuf, InputError> {
    let is_name = argument.extension().is_none() && argument.components().count() == 1;
    let is_there = std::fs::metadata(argument).is_ok_and(|found| !found.is_dir());
    if !is_name || is_there || argument == Path::new("-") {
        return Ok(argument.to_owned());
    }
    let name = argument.to_string_lossy();
    match shipped(kind).find(|input| input.name == name) {
        Some(input) => Ok(unpack(argument)?.join(input.path)),
        None if argument.exists() => Ok(argument.to_owned()),
        None => Err(InputError::file(argument, no_such_input(kind, &name))),
    }
}

fn no_such_input(kind: ShippedKind, name: &str) -> String {
    let what = match kind {
        ShippedKind::Scenario => "scenario",
        ShippedKind::Robot => "robot",
        ShippedKind::World => "world",
    };
    let hint = format!("'surefoot list' shows the {what}s that the program carries");
    match closest(name, shipped(kind).map(|input| input.name)) {
        Some(close) => format!("no such file or {what}; did you mean '{close}'? {hint}"),
        None => format!("no such file or {what}; {hint}"),
    }
}

/// The name most like this one, if any is.
pub fn closest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    names
        .map(|other| (strsim::jaro_winkler(name, other), other))
        .filter(|(likeness, _)| *likeness >= LIKENESS_MIN)
        .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)))
        .map(|(_, other)| other)
}

/// Writes the shipped files to the cache folder where they are not there yet, and returns their
/// folder.
fn unpack(argument: &Path) -> Result<PathBuf, InputError> {
    let folder = cache_folder()
        .ok_or_else(|| {
            InputError::file(argument, format!("{NO_CACHE_FOLDER}; set one, or name a file"))
        })?
        .join(format!("configs-{}", digest()));
    for (path, bytes) in FILES {
        let path = folder.join(path);
        if cache_file::read(&path).is_some_and(|there| there == *bytes) {
            continue;
        }
        cache_file::write(&path, bytes).map_err(|error| {
            InputError::file(&path, format!("cannot be written: {error}; name a file instead"))
        })?;
    }
    Ok(folder)
}

/// The first digits of the digest of all shipped files.
fn digest() -> String {
    let mut hash = Sha256::new();
    for (path, bytes) in FILES {
        hash.update((path.len() as u64).to_le_bytes());
        hash.update(path);
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_input_has_a_summary() {
        for kind in [ShippedKind::Scenario, ShippedKind::Robot, ShippedKind::World] {
            assert!(shipped(kind).count() > 0);
            for input in shipped(kind) {
                assert!(input.summary.ends_with('.'), "{input:?}");
                assert!(bytes_of(input.path).is_some());
            }
        }
    }

    #[test]
    fn paths_stay_and_close_names_are_proposed() {
        let path = Path::new("folder/ibeam_hallway");
        assert_eq!(scenario_path(path).unwrap(), path);
        let error = scenario_path(Path::new("ibeam_halway")).unwrap_err().to_string();
        assert!(error.contains("did you mean 'ibeam_hallway'?"), "{error}");
        let error = input_path(ShippedKind::Robot, Path::new("hubbo")).unwrap_err().to_string();
        assert!(error.contains("no such file or robot; did you mean 'hubo'?"), "{error}");
        let error = scenario_path(Path::new("qqqq")).unwrap_err().to_string();
        assert!(error.contains("'surefoot list'") && !error.contains("mean"), "{error}");
    }
}
