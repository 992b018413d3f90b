//! The parameters of planning, checking and moving.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};

use crate::errors::exception;

/// The parameters of a scenario, `[planner]`, `[checker]` and `[execution]`.
#[pyclass(module = "surefoot._native", frozen)]
#[derive(Debug, Clone, Default)]
pub struct Parameters {
    /// Those of the library.
    pub inner: surefoot::Parameters,
}

#[pymethods]
impl Parameters {
    /// The defaults.
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// The same parameters with those of a JSON object of tables.
    fn with_json(&self, py: Python<'_>, text: &str) -> PyResult<Self> {
        match changed(self.inner.clone(), text) {
            Ok(inner) => Ok(Self { inner }),
            Err(message) => Err(exception(py, "ParameterError", message, &PyDict::new(py))?),
        }
    }

    /// All parameters as a JSON object of tables.
    fn to_json(&self) -> String {
        let surefoot::Parameters { planner, checker, execution } = &self.inner;
        serde_json::json!({ "planner": planner, "checker": checker, "execution": execution })
            .to_string()
    }
}

/// The parameters with the entries of a JSON object of tables.
fn changed(mut all: surefoot::Parameters, text: &str) -> Result<surefoot::Parameters, String> {
    let tables: Map<String, Value> = serde_json::from_str(text).map_err(shown)?;
    for (name, table) in tables {
        let change = match name.as_str() {
            "planner" => change_table(&mut all.planner, table),
            "checker" => change_table(&mut all.checker, table),
            "execution" => change_table(&mut all.execution, table),
            _ => Err("the tables are planner, checker and execution".to_owned()),
        };
        change.map_err(|reason| format!("[{name}]: {reason}"))?;
    }
    Ok(all)
}

/// Sets the entries of a table and keeps the others.
fn change_table<T>(table: &mut T, changes: Value) -> Result<(), String>
where
    T: serde::Serialize + serde::de::DeserializeOwned,
{
    let Value::Object(changes) = changes else { return Err("must be a table".to_owned()) };
    let mut all = serde_json::to_value(&*table).map_err(shown)?;
    if let Value::Object(all) = &mut all {
        all.extend(changes);
    }
    *table = serde_json::from_value(all).map_err(shown)?;
    Ok(())
}

fn shown(error: serde_json::Error) -> String {
    error.to_string()
}
