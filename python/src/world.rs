//! Worlds.

use std::path::PathBuf;

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use surefoot::picture::tessellate::triangles_of;
use surefoot::{HeightMap, Pose, Shape};

use crate::arrays::{Matrix, rows, rows_of};
use crate::errors::OrRaise;

/// A named surface: vertices (m) and triangles.
pub type NamedMesh<'py> = (String, Matrix<'py>, Bound<'py, numpy::PyArray2<u32>>);

/// A validated world.
#[pyclass(module = "surefoot._native", frozen)]
#[derive(Debug, Clone)]
pub struct World {
    /// That of the library.
    pub inner: surefoot::World,
}

#[pymethods]
impl World {
    /// Loads a world file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = py.detach(|| surefoot::World::load(path)).or_raise()?;
        Ok(Self { inner })
    }

    #[getter]
    fn friction(&self) -> f64 {
        self.inner.friction()
    }

    #[getter]
    fn shape_names(&self) -> Vec<String> {
        self.inner.shape_names().map(str::to_owned).collect()
    }

    #[getter]
    fn digest(&self) -> String {
        self.inner.model().digest.to_string()
    }

    /// The surface of each shape in the world's frame.
    fn meshes<'py>(&self, py: Python<'py>) -> PyResult<Vec<NamedMesh<'py>>> {
        let mut meshes = vec![];
        for shape in &self.inner.model().shapes {
            let Ok((vertices, triangles)) = triangles_of(&shape.shape, &shape.name) else {
                continue;
            };
            let pose = &shape.world_from_shape;
            let placed =
                vertices.iter().map(|v| (pose.rotation * *v + pose.translation).to_array());
            meshes.push((shape.name.clone(), rows(py, placed)?, rows(py, triangles)?));
        }
        Ok(meshes)
    }
}

/// Collects the shapes of a world.
#[pyclass(module = "surefoot._native")]
#[derive(Debug)]
pub struct WorldBuilder {
    inner: surefoot::WorldBuilder,
}

impl WorldBuilder {
    fn add(&mut self, name: &str, pose: ([f64; 3], [f64; 4]), shape: Shape) {
        let inner = self.inner.clone();
        self.inner = inner.shape(name, pose_of(pose), shape);
    }
}

fn pose_of((position, rotation): ([f64; 3], [f64; 4])) -> Pose {
    Pose { position, rotation }
}

#[pymethods]
impl WorldBuilder {
    #[new]
    fn new(friction: f64) -> Self {
        Self { inner: surefoot::World::builder().friction(friction) }
    }

    fn cuboid(&mut self, name: &str, pose: ([f64; 3], [f64; 4]), half_extents: [f64; 3]) {
        self.add(name, pose, Shape::cuboid(half_extents));
    }

    fn sphere(&mut self, name: &str, pose: ([f64; 3], [f64; 4]), radius: f64) {
        self.add(name, pose, Shape::sphere(radius));
    }

    fn cylinder(&mut self, name: &str, pose: ([f64; 3], [f64; 4]), radius: f64, length: f64) {
        self.add(name, pose, Shape::cylinder(radius, length));
    }

    fn capsule(&mut self, name: &str, pose: ([f64; 3], [f64; 4]), radius: f64, length: f64) {
        self.add(name, pose, Shape::capsule(radius, length));
    }

    fn convex(
        &mut self,
        name: &str,
        pose: ([f64; 3], [f64; 4]),
        points: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        self.add(name, pose, Shape::convex(&rows_of(&points, "points")?));
        Ok(())
    }

    fn mesh(
        &mut self,
        name: &str,
        pose: ([f64; 3], [f64; 4]),
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
    ) -> PyResult<()> {
        let (vertices, faces) = (rows_of(&vertices, "vertices")?, rows_of(&faces, "faces")?);
        self.inner = self.inner.clone().mesh(name, pose_of(pose), &vertices, &faces);
        Ok(())
    }

    fn height_map(
        &mut self,
        name: &str,
        pose: ([f64; 3], [f64; 4]),
        heights: PyReadonlyArray2<'_, f64>,
        spacing: f64,
    ) -> PyResult<()> {
        let columns = heights.shape()[1];
        let map = HeightMap { heights: heights.as_slice()?, columns, spacing };
        self.inner = self.inner.clone().height_map(name, pose_of(pose), &map);
        Ok(())
    }

    /// Validates all shapes.
    fn build(&self, py: Python<'_>) -> PyResult<World> {
        let inner = py.detach(|| self.inner.clone().build()).or_raise()?;
        Ok(World { inner })
    }
}
