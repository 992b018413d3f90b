//! Robots.

use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use glam::{DQuat, DVec3};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use surefoot::input::cache_folder::{NO_CACHE_FOLDER, cache_folder};
use surefoot::picture::tessellate::triangles_of;
use surefoot::{Parameters, PlannerConfig, PrepareError, Prepared};
use surefoot_controller_sim::kinematics::forward::{Configuration, Posture};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::Joint;

use crate::arrays::{Matrix, Vector, matrix, rows, rows_of, vector};
use crate::errors::OrRaise;
use crate::world::NamedMesh;

/// Numbers of a link pose: position, and rotation as x, y, z, w.
const POSE_LEN: usize = 7;

/// A validated biped.
#[pyclass(module = "surefoot._native", frozen)]
#[derive(Debug)]
pub struct Robot {
    /// That of the library.
    pub inner: surefoot::Robot,
    /// The preparation that was used last, and its margins.
    prepared: Mutex<Option<(PlannerConfig, Prepared)>>,
}

/// A preparation, and why it could not be saved.
type Made = (Prepared, Option<String>);

impl Robot {
    /// Wraps a robot.
    pub fn new(inner: surefoot::Robot) -> Self {
        Self { inner, prepared: Mutex::new(None) }
    }

    /// The preparation for these margins: that of the last time, one of the cache, or a new one.
    pub fn preparation(&self, py: Python<'_>, parameters: &Parameters) -> PyResult<Prepared> {
        let (prepared, warning) = py.detach(|| self.find_or_make(parameters)).or_raise()?;
        if let Some(reason) = warning {
            let text = format!("the robot's preparation cannot be saved: {reason}");
            let text = CString::new(text).unwrap_or_default();
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 2)?;
        }
        Ok(prepared)
    }

    fn find_or_make(&self, parameters: &Parameters) -> Result<Made, PrepareError> {
        let mut known = self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((config, prepared)) = &*known
            && *config == parameters.planner
        {
            return Ok((prepared.clone(), None));
        }
        let saved = match cache_folder() {
            Some(folder) => Prepared::in_folder(&self.inner, parameters, folder),
            None => Err(PrepareError::Save(std::io::Error::other(NO_CACHE_FOLDER))),
        };
        let (prepared, warning) = match saved {
            Err(PrepareError::Save(reason)) => {
                (Prepared::new(&self.inner, parameters)?, Some(reason.to_string()))
            }
            other => (other?, None),
        };
        *known = Some((parameters.planner.clone(), prepared.clone()));
        Ok((prepared, warning))
    }

    fn numbers<'py>(&self, py: Python<'py>, of: impl Fn(&Joint) -> f64) -> Vector<'py> {
        vector(py, self.inner.model().joints.iter().map(of))
    }
}

#[pymethods]
impl Robot {
    /// Loads a robot file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = py.detach(|| surefoot::Robot::load(path)).or_raise()?;
        Ok(Self::new(inner))
    }

    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.inner.mass()
    }

    #[getter]
    fn urdf_path(&self) -> PathBuf {
        self.inner.model().urdf_path.clone()
    }

    #[getter]
    fn digest(&self) -> String {
        self.inner.model().digest.to_string()
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.inner.joint_names().map(str::to_owned).collect()
    }

    #[getter]
    fn link_names(&self) -> Vec<String> {
        self.inner.model().links.iter().map(|link| link.name.clone()).collect()
    }

    #[getter]
    fn standing<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.inner.model().standing_q.iter().copied())
    }

    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.numbers(py, |joint| joint.lower)
    }

    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.numbers(py, |joint| joint.upper)
    }

    #[getter]
    fn effort<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.numbers(py, |joint| joint.effort)
    }

    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.numbers(py, |joint| joint.velocity)
    }

    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.numbers(py, |joint| joint.acceleration())
    }

    /// Name, link and outline in the sole frame (m) of each foot.
    #[getter]
    fn soles<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, String, Matrix<'py>)>> {
        let model = self.inner.model();
        let sole = |foot: &surefoot_shared_types::robot::model::Foot| {
            let outline = rows(py, foot.polygon.iter().map(|corner| corner.to_array()))?;
            Ok((foot.name.clone(), model.links[foot.link].name.clone(), outline))
        };
        model.feet.iter().map(sole).collect()
    }

    /// Poses of all links in the world, a row for each configuration and link, in this order.
    fn link_poses<'py>(
        &self,
        py: Python<'py>,
        root_positions: PyReadonlyArray2<'py, f64>,
        root_rotations: PyReadonlyArray2<'py, f64>,
        joints: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Matrix<'py>> {
        let positions = rows_of::<f64, 3>(&root_positions, "root_positions")?;
        let rotations = rows_of::<f64, 4>(&root_rotations, "root_rotations")?;
        let model = self.inner.model();
        let width = joints.shape()[1];
        if width != model.joints.len() || positions.len() != rotations.len() {
            let message = format!("joints must have {} columns", model.joints.len());
            return Err(pyo3::exceptions::PyValueError::new_err(message));
        }
        let mut poses = vec![];
        let configurations = joints.as_slice()?.chunks_exact(width.max(1));
        for ((position, rotation), q) in positions.iter().zip(&rotations).zip(configurations) {
            let rotation = DQuat::from_array(*rotation).normalize();
            let world_from_root = Pose::from_parts(DVec3::from_array(*position), rotation);
            let configuration = Configuration { world_from_root, q: q.to_vec() };
            for pose in Posture::new(model, &configuration).world_from_link {
                poses.extend(pose.translation.to_array());
                poses.extend(pose.rotation.to_array());
            }
        }
        matrix(py, poses, POSE_LEN)
    }

    /// The collision surface of each link in its frame; links without shapes are left out.
    fn link_meshes<'py>(&self, py: Python<'py>) -> PyResult<Vec<NamedMesh<'py>>> {
        let mut meshes = vec![];
        for link in &self.inner.model().links {
            let (mut vertices, mut triangles) = (Vec::<[f64; 3]>::new(), Vec::<[u32; 3]>::new());
            for part in &link.shapes {
                let Ok((corners, faces)) = triangles_of(&part.shape, &link.name) else { continue };
                let (first, pose) = (vertices.len() as u32, &part.link_from_shape);
                let placed = corners.iter().map(|v| pose.rotation * *v + pose.translation);
                vertices.extend(placed.map(|corner| corner.to_array()));
                triangles.extend(faces.iter().map(|face| face.map(|corner| first + corner)));
            }
            if !triangles.is_empty() {
                meshes.push((link.name.clone(), rows(py, vertices)?, rows(py, triangles)?));
            }
        }
        Ok(meshes)
    }
}
