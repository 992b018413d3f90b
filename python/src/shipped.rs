//! The robots, worlds and scenarios that the package carries.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use surefoot::input::shipped::{ShippedKind, input_path, shipped as inputs};

use crate::errors::OrRaise;

fn kind_of(kind: &str) -> PyResult<ShippedKind> {
    match kind {
        "robot" => Ok(ShippedKind::Robot),
        "world" => Ok(ShippedKind::World),
        "scenario" => Ok(ShippedKind::Scenario),
        _ => Err(PyValueError::new_err("a kind is robot, world or scenario")),
    }
}

/// The file that a path or the name of a shipped input means.
#[pyfunction]
pub fn resolve(kind: &str, argument: PathBuf) -> PyResult<PathBuf> {
    input_path(kind_of(kind)?, Path::new(&argument)).or_raise()
}

/// Name and summary of each shipped input of a kind.
#[pyfunction]
pub fn shipped(kind: &str) -> PyResult<Vec<(&'static str, String)>> {
    Ok(inputs(kind_of(kind)?).map(|input| (input.name, input.summary)).collect())
}
