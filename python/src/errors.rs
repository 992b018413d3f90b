//! Errors of the library as the exceptions of `surefoot.errors`.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use surefoot::{
    AnswerError, BuildError, CheckError, LoadError, PlanError, PrepareError, SaveError, StartError,
    WorldError,
};
use surefoot_shared_types::InputError;
use surefoot_shared_types::config::builder::ScenarioError;

/// The result of a library call, or a Python exception.
pub trait OrRaise<T> {
    /// The value, or the exception that stands for the error.
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Raise> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|error| Python::attach(|py| error.exception(py).unwrap_or_else(|other| other)))
    }
}

/// An error with a Python exception.
pub trait Raise: ToString {
    /// The exception.
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr>;
}

/// An exception of a class of `surefoot.errors`, with its message and its fields.
pub fn exception(
    py: Python<'_>,
    class: &str,
    message: String,
    fields: &Bound<'_, PyDict>,
) -> PyResult<PyErr> {
    let class = py.import("surefoot.errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call((message,), Some(fields))?))
}

/// An exception that has a message alone.
fn plain(py: Python<'_>, class: &str, error: &impl ToString) -> PyResult<PyErr> {
    exception(py, class, error.to_string(), &PyDict::new(py))
}

impl Raise for InputError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        let fields = PyDict::new(py);
        fields.set_item("path", &self.path)?;
        fields.set_item("line", self.line)?;
        fields.set_item("element", self.element.as_deref())?;
        let others: Vec<String> = self.others.iter().map(ToString::to_string).collect();
        fields.set_item("others", others)?;
        exception(py, "InputError", self.to_string(), &fields)
    }
}

impl Raise for LoadError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        self.input_error().exception(py)
    }
}

impl Raise for SaveError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        self.input_error().exception(py)
    }
}

impl Raise for ScenarioError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        let fields = PyDict::new(py);
        fields.set_item("parameter", &self.parameter)?;
        exception(py, "ParameterError", self.to_string(), &fields)
    }
}

impl Raise for WorldError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        let fields = PyDict::new(py);
        if let Self::Shape { name, .. } = self {
            fields.set_item("shape", name)?;
        }
        exception(py, "WorldError", self.to_string(), &fields)
    }
}

impl Raise for PrepareError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        plain(py, "RobotError", self)
    }
}

impl Raise for BuildError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        match self {
            Self::Parameter(error) => error.exception(py),
            Self::NoThread | Self::Planner(_) => plain(py, "RobotError", self),
        }
    }
}

impl Raise for StartError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        match self {
            Self::Stance(error) => error.exception(py),
            Self::Planner(_) => plain(py, "RobotError", self),
        }
    }
}

impl Raise for CheckError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        match self {
            Self::Checker(_) => plain(py, "RobotError", self),
            Self::File(error) => error.exception(py),
        }
    }
}

impl Raise for AnswerError {
    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        match self {
            Self::Stance(error) => error.exception(py),
            Self::Plan(error) => error.exception(py),
        }
    }
}

/// The name of an outcome without a plan, as in reports; `None` if the search could not begin.
pub fn outcome(error: &PlanError) -> Option<&'static str> {
    Some(match error {
        PlanError::Start(_) => return None,
        PlanError::BudgetExhausted { .. } => "budget_exhausted",
        PlanError::ArenaFull { .. } => "arena_full",
        PlanError::Impossible(_) => "impossible",
        PlanError::StartInvalid(_) => "start_invalid",
        PlanError::GoalInvalid(_) => "goal_invalid",
    })
}
