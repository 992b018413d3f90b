//! The scenarios of a bench, all loaded before anything is measured.

use std::path::{Path, PathBuf};

use surefoot_shared_types::InputError;
use surefoot_shared_types::config::MotionKind;

use crate::cli::shared_bench_arguments::ScenarioArguments;
use crate::input::inputs::{Inputs, Overrides};

/// The motion of the plans of most benches: the searched one, since they measure the search.
pub const SEARCHED: Overrides = Overrides { seed: None, motion: Some(MotionKind::QuasiStatic) };

/// Loads the scenarios asked for, or those of these names, with the searched motion.
///
/// # Errors
/// When one of their files cannot be used.
pub fn load(arguments: &ScenarioArguments, all: &[&str]) -> Result<Vec<Inputs>, InputError> {
    load_with(arguments, all, SEARCHED)
}

/// Loads the scenarios asked for, or those of these names.
///
/// # Errors
/// When one of their files cannot be used.
pub fn load_with(
    arguments: &ScenarioArguments,
    all: &[&str],
    overrides: Overrides,
) -> Result<Vec<Inputs>, InputError> {
    let asked = &arguments.scenarios;
    let names: Vec<&str> =
        if asked.is_empty() { all.into() } else { asked.iter().map(String::as_str).collect() };
    names.into_iter().map(|name| Inputs::load(&path(&arguments.configs, name), overrides)).collect()
}

/// The file of a scenario given by its name or as a file.
pub fn path(folder: &Path, name: &str) -> PathBuf {
    let is_file = name.contains('/')
        || Path::new(name).extension().is_some_and(|extension| extension == "toml");
    if is_file { PathBuf::from(name) } else { folder.join(format!("{name}.toml")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_is_named_or_given_as_a_file() {
        let folder = Path::new("configs/scenarios");
        for (given, expected) in [
            ("beam", "configs/scenarios/beam.toml"),
            ("beam.toml", "beam.toml"),
            ("./mine/beam.toml", "./mine/beam.toml"),
            ("/tmp/beam", "/tmp/beam"),
        ] {
            assert_eq!(path(folder, given), Path::new(expected));
        }
    }
}
