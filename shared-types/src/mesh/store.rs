//! Triangle meshes from STL, OBJ and COLLADA files.

use crate::mesh::collada;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::base::digest::Digest;
use crate::base::text_file;
use crate::base::text_file::{NUMBER_MAX, absolute, read_bytes};
use crate::geometry::convex_hull::hull_points;
use crate::geometry::shape::MeshSource;
use crate::geometry::shape::Shape;

/// Largest mesh file, bytes.
const MESH_BYTES_MAX: u64 = 1 << 30;
/// Triangles of less than twice this area (m2, squared) are dropped.
const DOUBLE_AREA_SQUARED_MIN: f64 = 1e-24;
/// The coarsest grid of vertices that is still exact enough, m. STL and OBJ files are read in
/// single precision.
const GRID_MAX: f64 = 5e-4;

/// Meshes by file, each read once, with the digests of all of them in the order of first use.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    files: BTreeMap<PathBuf, RawMesh>,
    digests: Vec<Digest>,
}

#[derive(Debug, Default)]
pub(crate) struct RawMesh {
    vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl MeshStore {
    /// The surface in a file, scaled. A mirroring scale keeps its normals outward.
    pub(crate) fn surface(&mut self, path: &Path, scale: DVec3) -> Result<Shape, String> {
        let (vertices, mut triangles) = self.scaled(path, scale)?;
        if scale.x * scale.y * scale.z < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        triangles.retain(|triangle| has_area(triangle.map(|index| vertices[index as usize])));
        if triangles.is_empty() {
            return Err(format!("mesh {} has no triangle of any area", path.display()));
        }
        Ok(Shape::Mesh { vertices, triangles, source: MeshSource { path: absolute(path), scale } })
    }

    /// The convex hull of a file's triangles, scaled.
    pub(crate) fn hull(&mut self, path: &Path, scale: DVec3) -> Result<Shape, String> {
        let (vertices, _) = self.scaled(path, scale)?;
        let points = hull_points(vertices)
            .map_err(|message| format!("mesh {}: {message}", path.display()))?;
        Ok(Shape::ConvexHull { points })
    }

    /// The digest of all files read so far.
    pub(crate) fn digest(&self) -> Digest {
        self.digests.iter().fold(Digest::default(), |all, one| all.chain(&one.0))
    }

    fn scaled(&mut self, path: &Path, scale: DVec3) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), String> {
        text_file::check_numbers("scale", &scale.to_array())?;
        if scale.to_array().contains(&0.0) {
            return Err("scale holds 0; leave it out to keep the file's size".into());
        }
        let mesh = self.load(path)?;
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|vertex| *vertex * scale).collect();
        let farthest = vertices.iter().map(|vertex| vertex.abs().max_element()).fold(0.0, f64::max);
        if farthest > NUMBER_MAX {
            return Err(format!(
                "mesh {} has a vertex at {farthest}, beyond {NUMBER_MAX:e}",
                path.display()
            ));
        }
        if !is_collada(path) && farthest * f64::from(f32::EPSILON) > GRID_MAX {
            return Err(format!(
                "mesh {} reaches {farthest} m from its origin, where single precision is too coarse; move it there and give the shape a pose",
                path.display()
            ));
        }
        Ok((vertices, mesh.triangles.clone()))
    }

    fn load(&mut self, path: &Path) -> Result<&RawMesh, String> {
        if !self.files.contains_key(path) {
            let in_file = |message: String| format!("mesh {} {message}", path.display());
            let bytes = read_bytes(path, MESH_BYTES_MAX).map_err(in_file)?;
            let mesh = parse(path, &bytes).map_err(in_file)?;
            self.digests.push(Digest::of(&[&bytes]));
            self.files.insert(path.to_owned(), mesh);
        }
        Ok(&self.files[path])
    }
}

fn parse(path: &Path, bytes: &[u8]) -> Result<RawMesh, String> {
    let mut welder = Welder::default();
    if is_collada(path) {
        collada::read(bytes, &mut welder)?;
    } else {
        read_stl_or_obj(path, bytes, &mut welder)?;
    }
    if welder.mesh.triangles.is_empty() {
        return Err("holds no triangles".into());
    }
    Ok(welder.mesh)
}

fn is_collada(path: &Path) -> bool {
    !matches!(
        path.extension().and_then(std::ffi::OsStr::to_str),
        Some("stl" | "STL" | "obj" | "OBJ")
    )
}

fn read_stl_or_obj(path: &Path, bytes: &[u8], welder: &mut Welder) -> Result<(), String> {
    let no_side_files = |_: &Path| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
    // mesh-loader 0.1.13 reads STL and OBJ with checked accesses throughout: no damage makes it
    // panic.
    let scene = mesh_loader::Loader::default()
        .load_from_slice_with_reader(bytes, path, no_side_files)
        .map_err(|error| format!("cannot be parsed: {error}"))?;
    for part in &scene.meshes {
        for face in &part.faces {
            let [a, b, c] = face.map(|index| {
                let vertex = part.vertices.get(index as usize);
                vertex.ok_or_else(|| {
                    format!("has a triangle with vertex {index} of {}", part.vertices.len())
                })
            });
            welder.push([*a?, *b?, *c?].map(|vertex| DVec3::from_array(vertex.map(f64::from))))?;
        }
    }
    Ok(())
}

/// Joins vertices at the same place, which STL files repeat for every triangle.
#[derive(Default)]
pub(crate) struct Welder {
    index: BTreeMap<[u64; 3], u32>,
    pub(crate) mesh: RawMesh,
}

impl Welder {
    pub(crate) fn push(&mut self, corners: [DVec3; 3]) -> Result<(), String> {
        if let Some(vertex) = corners.iter().find(|vertex| !vertex.is_finite()) {
            return Err(format!("has a vertex that is not finite: {vertex}"));
        }
        let triangle = corners.map(|vertex| self.weld(vertex));
        self.mesh.triangles.push(triangle);
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

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a).length_squared() > DOUBLE_AREA_SQUARED_MIN
}
