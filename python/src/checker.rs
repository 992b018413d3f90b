//! The controller's checks.

use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use surefoot::report::margins::WorstMargins;
use surefoot::{FootLoad, Load};
use surefoot_controller_sim::PlanReport;
use surefoot_controller_sim::plan::EndpointReport;
use surefoot_controller_sim::plan::plan_check::CheckResult;

use crate::arrays::{matrix, rows, vector};
use crate::errors::OrRaise;
use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::planning::{GoalNumbers, StanceNumbers, goal_of, stance_of};
use crate::robot::Robot;
use crate::world::World;

/// Checks walks of one robot in one world.
#[pyclass(module = "surefoot._native", frozen)]
pub struct Checker {
    inner: Mutex<surefoot::Checker>,
}

#[pymethods]
impl Checker {
    #[new]
    fn new(
        py: Python<'_>,
        robot: &Robot,
        world: &World,
        parameters: &Parameters,
    ) -> PyResult<Self> {
        let (robot, world, parameters) = (&robot.inner, &world.inner, &parameters.inner);
        let inner = py.detach(|| surefoot::Checker::new(robot, world, parameters)).or_raise()?;
        Ok(Self { inner: Mutex::new(inner) })
    }

    /// The report on a walk from a start to a goal, or to the ends that the plan states, as JSON.
    #[pyo3(signature = (plan, ends=None))]
    fn check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        ends: Option<(StanceNumbers, GoalNumbers)>,
    ) -> PyResult<String> {
        let report = py.detach(|| {
            let checker = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
            match ends {
                Some((start, goal)) => checker.answer(&plan.inner, stance_of(start), goal_of(goal)),
                None => checker.answer_as_stated(&plan.inner),
            }
        });
        Ok(report_json(&report.or_raise()?).to_string())
    }

    /// The worst margins of each chunk as a JSON list of objects; null where a check is violated.
    fn margins(&self, py: Python<'_>, plan: &Plan) -> String {
        let chunks = plan.inner.chunks();
        let margins: Vec<Value> = py.detach(|| {
            let mut checker = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
            let of_chunk = |chunk| match checker.check(chunk) {
                Ok(margins) => json!(WorstMargins::from(&margins)),
                Err(_) => Value::Null,
            };
            chunks.iter().map(of_chunk).collect()
        });
        Value::from(margins).to_string()
    }

    /// The loads along a plan, one every `tick` s, by name of the field.
    fn loads<'py>(&self, py: Python<'py>, plan: &Plan, tick: f64) -> PyResult<Bound<'py, PyDict>> {
        let loads: Vec<Load> = py.detach(|| {
            self.inner.lock().unwrap_or_else(PoisonError::into_inner).loads(&plan.inner, tick)
        });
        let joints = loads.first().map_or(0, |load| load.torques.len());
        let numbers = |of: fn(&Load) -> f64| vector(py, loads.iter().map(of));
        let feet = |of: fn(&FootLoad) -> [f64; 3]| {
            let places = loads.iter().map(|load| per_foot(load, of));
            matrix(py, places.flatten().collect(), 6)
        };
        let fields = PyDict::new(py);
        fields.set_item("time", numbers(|load| load.time))?;
        let centres = loads.iter().map(|load| load.centre_of_mass);
        fields.set_item("centre_of_mass", rows(py, centres)?)?;
        fields.set_item("balance_margin", numbers(|load| load.balance_margin))?;
        fields.set_item("friction_use", numbers(|load| load.friction_use))?;
        fields.set_item("torque_use", numbers(|load| load.torque_use))?;
        fields.set_item("forces", feet(|foot| foot.force)?)?;
        fields.set_item("pressure_centres", feet(|foot| foot.centre)?)?;
        let torques = loads.iter().flat_map(|load| &load.torques).copied();
        fields.set_item("torques", matrix(py, torques.collect(), joints)?)?;
        Ok(fields)
    }
}

/// A vector of the left foot, then one of the right; not a number for a foot that is no stance
/// foot.
fn per_foot(load: &Load, of: fn(&FootLoad) -> [f64; 3]) -> [f64; 6] {
    let mut numbers = [f64::NAN; 6];
    for foot in &load.feet {
        let at = 3 * foot.foot as usize;
        numbers[at..at + 3].copy_from_slice(&of(foot));
    }
    numbers
}

fn report_json(report: &PlanReport) -> Value {
    json!({
        "valid": report.is_valid(),
        "checks": report.checks.iter().map(check_json).collect::<Vec<_>>(),
        "margins": WorstMargins::from(&report.margins),
        "start": end_json(&report.start),
        "goal": end_json(&report.goal),
        "notes": report.notes,
    })
}

fn check_json(result: &CheckResult) -> Value {
    let violation = result.violation.as_ref().map(|placed| {
        json!({
            "phase": placed.phase,
            "waypoint": placed.violation.waypoint,
            "detail": placed.violation.detail,
        })
    });
    json!({
        "check": result.check.name(),
        "margin": result.worst.map(|worst| worst.margin),
        "phase": result.worst.map(|worst| worst.phase),
        "violation": violation,
    })
}

fn end_json(end: &EndpointReport) -> Value {
    let error = Some(end.error).filter(|error| error.is_finite());
    json!({ "error": error, "limit": end.limit, "violation": end.violation })
}
