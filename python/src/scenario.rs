//! Scenario files.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::scenario::load::load_scenario as load;

use crate::errors::OrRaise;
use crate::parameters::Parameters;

/// The fields of a scenario file. Its robot is opened only where a stance has no width, its world
/// is not.
#[pyfunction]
pub fn load_scenario(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let scenario = load(&path).or_raise()?;
    let fields = PyDict::new(py);
    fields.set_item("name", scenario.name)?;
    fields.set_item("robot", scenario.robot_path)?;
    fields.set_item("world", scenario.world_path)?;
    fields.set_item("start", numbers(&scenario.start))?;
    fields.set_item("goal", numbers(&scenario.goal))?;
    let tolerance = (scenario.goal_tolerance.position, scenario.goal_tolerance.yaw);
    fields.set_item("goal_tolerance", tolerance)?;
    fields.set_item("seed", scenario.seed)?;
    let (planner, checker, execution) = (scenario.planner, scenario.checker, scenario.execution);
    let inner = surefoot::Parameters { planner, checker, execution };
    fields.set_item("parameters", Py::new(py, Parameters { inner })?)?;
    Ok(fields)
}

fn numbers(stance: &StancePose) -> [f64; 5] {
    let [x, y, z] = stance.position.to_array();
    [x, y, z, stance.yaw, stance.stance_width]
}
