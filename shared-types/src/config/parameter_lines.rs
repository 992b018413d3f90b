//! The lines of a scenario file that set parameters.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::config::scenario_source::ScenarioSource;

/// The tables, with the position of each value in the file.
#[derive(Deserialize)]
struct Tables {
    #[serde(default)]
    planner: BTreeMap<String, Spanned<toml::Value>>,
    #[serde(default)]
    checker: BTreeMap<String, Spanned<toml::Value>>,
    #[serde(default)]
    execution: BTreeMap<String, Spanned<toml::Value>>,
}

/// The line of each parameter that a scenario file sets, by name, such as `planner.work_max`.
///
/// # Errors
/// It is not TOML.
pub fn parameter_lines(source: &ScenarioSource) -> Result<BTreeMap<String, usize>, InputError> {
    let source = &source.file;
    let Tables { planner, checker, execution } = source.parse_toml(FileKind::Scenario)?;
    let tables = [("planner", planner), ("checker", checker), ("execution", execution)];
    let lines = tables.into_iter().flat_map(|(table, values)| {
        let line = |value: &Spanned<toml::Value>| source.line(value.span().start);
        values.into_iter().map(move |(key, value)| (format!("{table}.{key}"), line(&value)))
    });
    Ok(lines.collect())
}
