//! The lines of a scenario file that set parameters.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::config::scenario_source::ScenarioSource;

/// Both tables, with the position of each value in the file.
#[derive(Deserialize)]
struct Tables {
    #[serde(default)]
    planner: BTreeMap<String, Spanned<toml::Value>>,
    #[serde(default)]
    checker: BTreeMap<String, Spanned<toml::Value>>,
}

/// The line of each parameter that a scenario file sets, by name, such as `planner.work_max`.
///
/// # Errors
/// It is not TOML.
pub fn parameter_lines(source: &ScenarioSource) -> Result<BTreeMap<String, usize>, InputError> {
    let source = &source.file;
    let Tables { planner, checker } = source.parse_toml(FileKind::Scenario)?;
    let planner = planner.into_iter().map(|(key, value)| (format!("planner.{key}"), value));
    let checker = checker.into_iter().map(|(key, value)| (format!("checker.{key}"), value));
    let lines = planner.chain(checker).map(|(name, value)| (name, source.line(value.span().start)));
    Ok(lines.collect())
}
