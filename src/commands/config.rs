//! `surefoot config show`: every parameter with its value and where the value comes from.
//! `surefoot config iceoryx2`: where an instance's shared memory is.

use std::collections::BTreeMap;
use std::ops::Bound;
use std::path::{Path, PathBuf};

use serde_json::json;
use surefoot_shared_types::config::parameter::{Parameter, Range, Value};
use surefoot_shared_types::config::parameter_lines::parameter_lines;
use surefoot_shared_types::config::parameters::PARAMETERS;
use surefoot_shared_types::config::scenario_source::ScenarioSource;
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::scenario::load::scenario_of;

use crate::cli::arguments::{ConfigIceoryxArguments, ConfigShowArguments};
use crate::input::shipped::scenario_path;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// The parameters in use, and the lines of the scenario file that set them.
struct Configuration {
    scenario: Option<PathBuf>,
    planner: PlannerConfig,
    checker: CheckerConfig,
    execution: ExecutionConfig,
    lines: BTreeMap<String, usize>,
}

/// Runs the command.
///
/// # Errors
/// The scenario cannot be used.
pub fn run(arguments: &ConfigShowArguments) -> Result<CommandOutcome, CommandError> {
    let configuration = configuration(arguments.scenario.as_deref())?;
    let text = if arguments.json { configuration.json() } else { configuration.table() };
    terminal::print_result(&text);
    Ok(CommandOutcome::Done)
}

/// Prints iceoryx2's configuration of a running instance, for iceoryx2's own programs.
///
/// # Errors
/// There is no such instance.
pub fn print_iceoryx(arguments: &ConfigIceoryxArguments) -> Result<CommandOutcome, CommandError> {
    let instance = Instance::attach(&arguments.instance)?;
    terminal::print_result(&format!(
        "[global]\nroot-path = \"{}\"\nprefix = \"{}\"",
        instance.root().display(),
        instance.segment_prefix()
    ));
    Ok(CommandOutcome::Done)
}

fn configuration(scenario: Option<&Path>) -> Result<Configuration, CommandError> {
    let scenario = scenario.map(scenario_path).transpose()?;
    let (planner, checker, execution, lines) = match &scenario {
        Some(path) => {
            let source = ScenarioSource::read(path)?;
            let loaded = scenario_of(&source)?;
            (loaded.planner, loaded.checker, loaded.execution, parameter_lines(&source)?)
        }
        None => Default::default(),
    };
    Ok(Configuration { scenario, planner, checker, execution, lines })
}

impl Configuration {
    fn value(&self, parameter: &Parameter) -> Value {
        (parameter.value)(&self.planner, &self.checker, &self.execution)
    }

    /// The scenario file and the line, or `default`.
    fn origin(&self, parameter: &Parameter) -> String {
        match (&self.scenario, self.lines.get(parameter.name)) {
            (Some(path), Some(line)) => format!("{}:{line}", path.display()),
            _ => "default".to_owned(),
        }
    }

    fn table(&self) -> String {
        let header = ["parameter", "value", "unit", "default", "range", "origin"];
        let mut rows = vec![header.map(str::to_owned)];
        rows.extend(PARAMETERS.iter().map(|parameter| {
            [
                parameter.name.to_owned(),
                self.value(parameter).rounded().to_string(),
                parameter.unit.to_owned(),
                parameter.default_value().rounded().to_string(),
                parameter.range.to_string(),
                self.origin(parameter),
            ]
        }));
        let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
        let widths: [usize; 6] = std::array::from_fn(width);
        let lines = rows.iter().map(|row| {
            let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    fn json(&self) -> String {
        let parameters: Vec<serde_json::Value> =
            PARAMETERS.iter().map(|parameter| self.json_of(parameter)).collect();
        let scenario = self.scenario.as_ref().map(|path| path.display().to_string());
        json!({ "scenario": scenario, "parameters": parameters }).to_string()
    }

    fn json_of(&self, parameter: &Parameter) -> serde_json::Value {
        let line = self.lines.get(parameter.name);
        json!({
            "name": parameter.name,
            "value": number(self.value(parameter)),
            "unit": parameter.unit,
            "default": number(parameter.default_value()),
            "range": range(parameter.range),
            "relation": parameter.relation,
            "effect": parameter.effect.replace('`', ""),
            "source": parameter.source.replace('`', ""),
            "origin": if line.is_some() { "scenario" } else { "default" },
            "line": line,
        })
    }
}

fn number(value: Value) -> serde_json::Value {
    match value {
        Value::Count(count) => count.into(),
        Value::Real(number) => number.into(),
        Value::Name(name) => name.into(),
    }
}

/// The ends of a range, and whether it includes them.
fn range(range: Range) -> serde_json::Value {
    let end = |bound: Bound<f64>| match bound {
        Bound::Included(end) => (Some(end), true),
        Bound::Excluded(end) => (Some(end), false),
        Bound::Unbounded => (None, false),
    };
    match range {
        Range::Counts { least, most } => json!({
            "min": least, "min_included": true, "max": most, "max_included": true,
        }),
        Range::Reals { low, high } => {
            let ((min, min_included), (max, max_included)) = (end(low), end(high));
            json!({
                "min": min, "min_included": min_included,
                "max": max, "max_included": max_included,
            })
        }
        Range::Names(names) => json!({ "names": names }),
    }
}
