//! The triangles of a file, with joined vertices, and the defects of the file.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::polygon::{PolygonTriangles, Polygons};

/// Why a mesh file cannot be used, and the line, where the format has lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct MeshError {
    pub(crate) line: Option<usize>,
    pub(crate) message: String,
}

impl MeshError {
    /// An error at a line, from 1.
    pub(crate) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }
}

impl From<String> for MeshError {
    fn from(message: String) -> Self {
        Self { line: None, message }
    }
}

impl From<&str> for MeshError {
    fn from(message: &str) -> Self {
        message.to_owned().into()
    }
}

/// A face that is no plane polygon. A convex hull needs only its corners, a surface is undefined
/// there.
#[derive(Debug, Clone)]
pub(crate) struct BentFace {
    /// How far its corners lie off one plane, in the file's unit; infinite where its outline
    /// crosses itself.
    pub(crate) off_plane: f64,
    pub(crate) line: Option<usize>,
}

/// The content of a mesh file.
#[derive(Debug, Default)]
pub(crate) struct RawMesh {
    /// In the order in which the faces use them first.
    pub(crate) vertices: Vec<DVec3>,
    /// Also those without area.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The face of which the corners lie furthest off one plane.
    pub(crate) most_bent: Option<BentFace>,
    /// Whether coordinates have single precision only.
    pub(crate) is_single: bool,
}

/// Collects faces. Joins vertices at the same place, which STL files repeat for every triangle.
#[derive(Default)]
pub(crate) struct Welder {
    index: BTreeMap<[u64; 3], u32>,
    polygons: Polygons,
    pub(crate) mesh: RawMesh,
}

impl Welder {
    pub(crate) fn push(&mut self, corners: [DVec3; 3]) -> Result<(), String> {
        check_finite(&corners)?;
        let triangle = corners.map(|vertex| self.weld(vertex));
        self.mesh.triangles.push(triangle);
        Ok(())
    }

    /// Adds a face of at least three corners, which stands in `line`.
    pub(crate) fn push_polygon(
        &mut self,
        corners: &[DVec3],
        line: Option<usize>,
    ) -> Result<(), String> {
        if let [a, b, c] = *corners {
            return self.push([a, b, c]);
        }
        check_finite(corners)?;
        let indices: Vec<u32> = corners.iter().map(|corner| self.weld(*corner)).collect();
        let PolygonTriangles { triangles, off_plane } = self.polygons.cut(corners);
        self.mesh.triangles.extend(triangles.iter().map(|of| of.map(|at| indices[at])));
        let known = self.mesh.most_bent.as_ref().map_or(0.0, |face| face.off_plane);
        if off_plane > known {
            self.mesh.most_bent = Some(BentFace { off_plane, line });
        }
        Ok(())
    }

    fn weld(&mut self, vertex: DVec3) -> u32 {
        // The sum turns -0 into 0.
        let vertex = vertex + DVec3::ZERO;
        let next = self.mesh.vertices.len() as u32;
        *self.index.entry(vertex.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.mesh.vertices.push(vertex);
            next
        })
    }
}

fn check_finite(corners: &[DVec3]) -> Result<(), String> {
    match corners.iter().find(|vertex| !vertex.is_finite()) {
        Some(vertex) => Err(format!("has a vertex that is not finite: {vertex}")),
        None => Ok(()),
    }
}
