//! Plans.

use std::path::PathBuf;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use surefoot::{Foot, PlanChunk};
use surefoot_shared_types::message::{SupportMode, Waypoint};

use crate::arrays::{Matrix, Vector, matrix, rows, vector};
use crate::errors::OrRaise;
use crate::robot::Robot;
use crate::world::World;

/// A whole-body walk.
#[pyclass(module = "surefoot._native", frozen)]
#[derive(Debug, Clone)]
pub struct Plan {
    /// That of the library.
    pub inner: surefoot::Plan,
}

/// Foot (0 left, 1 right), time, position, rotation and supported polygon of each foothold.
type Footholds<'py> =
    (Bound<'py, PyArray1<u8>>, Vector<'py>, Matrix<'py>, Matrix<'py>, Vec<Matrix<'py>>);

impl Plan {
    /// The waypoints with the support mode of each. A waypoint that two chunks share counts once,
    /// with the mode of the motion that leads to it.
    fn waypoints(&self) -> impl Iterator<Item = (&Waypoint, u32)> {
        self.inner.chunks().iter().enumerate().flat_map(|(at, chunk)| {
            chunk
                .waypoints()
                .iter()
                .skip(usize::from(at > 0))
                .map(|waypoint| (waypoint, chunk.mode))
        })
    }

    fn joints_len(&self) -> usize {
        self.inner.chunks().first().map_or(0, |chunk| chunk.joints_len as usize)
    }
}

fn feet_of(mode: u32) -> [bool; 2] {
    let mode = SupportMode::from_wire(mode);
    [Foot::Left, Foot::Right].map(|foot| mode.is_some_and(|mode| mode.carries(foot as usize)))
}

#[pymethods]
impl Plan {
    /// Loads a plan file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = py.detach(|| surefoot::Plan::load(path)).or_raise()?;
        Ok(Self { inner })
    }

    /// Saves the plan as a file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.inner.save(path)).or_raise()
    }

    #[getter]
    fn digest(&self) -> String {
        self.inner.digest().to_string()
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }

    fn robot(&self) -> Robot {
        Robot::new(self.inner.robot().clone())
    }

    fn world(&self) -> World {
        World { inner: self.inner.world().clone() }
    }

    /// Begin and end (s) of each chunk.
    fn chunk_times<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let times = |chunk: &PlanChunk| {
            let waypoints = chunk.waypoints();
            [waypoints.first(), waypoints.last()].map(|one| one.map_or(0.0, |one| one.time))
        };
        rows(py, self.inner.chunks().iter().map(times))
    }

    /// The waypoints, by name of the field.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let joints = self.joints_len();
        let q = self.waypoints().flat_map(|(waypoint, _)| &waypoint.q[..joints]).copied();
        let fields = PyDict::new(py);
        fields.set_item("time", vector(py, self.waypoints().map(|(waypoint, _)| waypoint.time)))?;
        let positions = self.waypoints().map(|(waypoint, _)| waypoint.root_position);
        fields.set_item("root_position", rows(py, positions)?)?;
        let rotations = self.waypoints().map(|(waypoint, _)| waypoint.root_rotation);
        fields.set_item("root_rotation", rows(py, rotations)?)?;
        fields.set_item("joints", matrix(py, q.collect(), joints)?)?;
        let contacts = self.waypoints().map(|(_, mode)| feet_of(mode));
        fields.set_item("contacts", rows(py, contacts)?)?;
        Ok(fields)
    }

    /// The start stance and each landing.
    fn footholds<'py>(&self, py: Python<'py>) -> PyResult<Footholds<'py>> {
        let all = self.inner.footholds();
        let polygon = |foothold: &surefoot::Foothold| rows(py, foothold.polygon.iter().copied());
        Ok((
            vector(py, all.iter().map(|foothold| foothold.foot as u8)),
            vector(py, all.iter().map(|foothold| foothold.time)),
            rows(py, all.iter().map(|foothold| foothold.position))?,
            rows(py, all.iter().map(|foothold| foothold.rotation))?,
            all.iter().map(polygon).collect::<PyResult<_>>()?,
        ))
    }

    /// The motion at these times, by name of the field.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let times = times.as_slice()?;
        let states: Vec<surefoot::State> =
            py.detach(|| times.iter().map(|time| self.inner.sample(*time)).collect());
        let joints = self.joints_len();
        let numbers = |of: fn(&surefoot::State) -> &[f64], columns: usize| {
            matrix(py, states.iter().flat_map(of).copied().collect(), columns)
        };
        let fields = PyDict::new(py);
        fields.set_item("time", vector(py, states.iter().map(|state| state.time)))?;
        let positions = states.iter().map(|state| state.world_from_root.position);
        fields.set_item("root_position", rows(py, positions)?)?;
        let rotations = states.iter().map(|state| state.world_from_root.rotation);
        fields.set_item("root_rotation", rows(py, rotations)?)?;
        fields.set_item("joints", numbers(|state| &state.q, joints)?)?;
        fields.set_item("root_velocity", numbers(|state| &state.velocity[..6], 6)?)?;
        fields.set_item("joint_velocity", numbers(|state| &state.velocity[6..], joints)?)?;
        fields.set_item("root_acceleration", numbers(|state| &state.acceleration[..6], 6)?)?;
        fields
            .set_item("joint_acceleration", numbers(|state| &state.acceleration[6..], joints)?)?;
        fields.set_item("torque", numbers(|state| &state.torque, joints)?)?;
        let feet = [Foot::Left, Foot::Right];
        let contacts = states.iter().map(|state| feet.map(|foot| state.contacts.is_stance(foot)));
        fields.set_item("contacts", rows(py, contacts)?)?;
        Ok(fields)
    }
}
