//! Planning.

use std::fmt::Display;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use surefoot::{Goal, Improvement, PlanError, Planner, SearchStats, SearchTrace, Stance, Step};
use surefoot_shared_types::config::builder::{ScenarioContent, ScenarioError};

use crate::arrays::{Matrix, rows};
use crate::errors::{OrRaise, Raise, exception, outcome};
use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::robot::Robot;
use crate::world::World;

/// Work units between two looks for a signal, some tens of milliseconds.
const WORK_PER_STEP: u64 = 2000;

/// x, y, z, yaw and width of a stance.
pub type StanceNumbers = (f64, f64, f64, f64, Option<f64>);
/// A goal's stance and its tolerances of position and yaw.
pub type GoalNumbers = (f64, f64, f64, f64, Option<f64>, f64, f64);

/// A stance from its numbers.
pub fn stance_of((x, y, z, yaw, width): StanceNumbers) -> Stance {
    Stance { width, ..Stance::at(x, y, z).with_yaw(yaw) }
}

/// A goal from its numbers.
pub fn goal_of((x, y, z, yaw, width, position, turn): GoalNumbers) -> Goal {
    let stance = stance_of((x, y, z, yaw, width));
    Goal { stance, position_tolerance: position, yaw_tolerance: turn }
}

/// What bounds and shapes one search.
#[derive(FromPyObject)]
struct Search {
    start: StanceNumbers,
    goal: GoalNumbers,
    seed: u64,
    threads: usize,
    improve: u64,
}

/// Finds a walk: the plan, the statistics of the search, and its guide route. Other Python threads
/// run meanwhile; a signal ends the search.
#[pyfunction]
pub fn plan<'py>(
    py: Python<'py>,
    robot: &Robot,
    world: &World,
    parameters: &Parameters,
    search: &Bound<'py, PyAny>,
) -> PyResult<(Plan, Bound<'py, PyDict>, Matrix<'py>)> {
    let Search { start, goal, seed, threads, improve } = search.extract()?;
    check(&parameters.inner, &robot.inner, start, goal, seed).or_raise()?;
    let prepared = robot.preparation(py, &parameters.inner)?;
    let builder = Planner::builder(&prepared, &world.inner)
        .parameters(parameters.inner.clone())
        .threads(threads)
        .improve(improve)
        .seed(seed);
    let mut planner = py.detach(|| builder.build()).or_raise()?;
    py.detach(|| planner.begin(stance_of(start), goal_of(goal))).or_raise()?;
    let result = loop {
        match py.detach(|| planner.step(WORK_PER_STEP)) {
            Step::Working => py.check_signals()?,
            Step::Done(result) => break result,
        }
    };
    let stats = stats_of(py, &planner.stats())?;
    if let Some(improvement) = planner.improvement() {
        stats.set_item("improved", improved(py, &improvement)?)?;
    }
    let trace = planner.trace();
    match result {
        Ok(inner) => Ok((Plan { inner }, stats, points(py, &trace)?)),
        Err(error) => Err(no_plan(py, &error, stats, &trace)?),
    }
}

/// Checks all numbers before the robot is prepared for them, which takes seconds.
fn check(
    parameters: &surefoot::Parameters,
    robot: &surefoot::Robot,
    start: StanceNumbers,
    goal: GoalNumbers,
    seed: u64,
) -> Result<(), ScenarioError> {
    let surefoot::Parameters { planner, checker, execution } = parameters.clone();
    let goal = goal_of(goal);
    let content = ScenarioContent {
        start: stance_of(start).pose(robot),
        goal: goal.stance.pose(robot),
        goal_position_tolerance: goal.position_tolerance,
        goal_yaw_tolerance: goal.yaw_tolerance,
        seed,
        planner,
        checker,
        execution,
    };
    content.build().map(|_| ())
}

fn points<'py>(py: Python<'py>, trace: &SearchTrace) -> PyResult<Matrix<'py>> {
    rows(py, trace.route.iter().map(|point| point.to_array()))
}

fn no_plan<'py>(
    py: Python<'py>,
    error: &PlanError,
    stats: Bound<'py, PyDict>,
    trace: &SearchTrace,
) -> PyResult<PyErr> {
    if let PlanError::Start(error) = error {
        return error.exception(py);
    }
    let fields = PyDict::new(py);
    fields.set_item("outcome", outcome(error))?;
    if let PlanError::ArenaFull { parameter } = error {
        fields.set_item("parameter", parameter)?;
    }
    fields.set_item("stats", stats)?;
    fields.set_item("route", points(py, trace)?)?;
    let edges = trace.tree.iter().flatten().map(|point| point.to_array());
    fields.set_item("tree", rows(py, edges)?)?;
    let bottleneck = trace.bottleneck.map(|place| place.to_array());
    fields.set_item("bottleneck", bottleneck)?;
    exception(py, "NoPlan", python_words(error), &fields)
}

/// The message, with the Python names of what it says to change.
fn python_words(error: &impl Display) -> String {
    error
        .to_string()
        .replace("PlannerBuilder::work_max", "work_max")
        .replace("in Parameters::planner", "in parameters['planner']")
}

fn improved<'py>(py: Python<'py>, improvement: &Improvement) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("first_work", improvement.first_work)?;
    fields.set_item("work", improvement.work)?;
    fields.set_item("first_seconds", improvement.first_seconds)?;
    fields.set_item("seconds", improvement.seconds)?;
    fields.set_item("rounds", improvement.rounds)?;
    fields.set_item("kept", improvement.kept)?;
    Ok(fields)
}

fn stats_of<'py>(py: Python<'py>, stats: &SearchStats) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("work", stats.work)?;
    fields.set_item("sequences", stats.sequences)?;
    fields.set_item("routes", stats.routes)?;
    fields.set_item("used_straight_line", stats.used_straight_line)?;
    fields.set_item("transitions_found", stats.transitions_found)?;
    fields.set_item("motions_found", stats.motions_found)?;
    fields.set_item("primitives", stats.primitives)?;
    Ok(fields)
}
