//! Triangle meshes from STL, OBJ and COLLADA files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::base::digest::Digest;
use crate::base::text_file;
use crate::base::text_file::{NUMBER_MAX, absolute, read_bytes};
use crate::geometry::convex_hull::hull_points;
use crate::geometry::shape::MeshSource;
use crate::geometry::shape::Shape;
use crate::mesh::format::{Format, foreign, format_of};
use crate::mesh::raw_mesh::{BentFace, MeshError, RawMesh, Welder};
use crate::mesh::{collada, obj, stl};

/// Largest mesh file, bytes.
const MESH_BYTES_MAX: u64 = 1 << 30;
/// Triangles of less than twice this area (m2, squared) are dropped.
const DOUBLE_AREA_SQUARED_MIN: f64 = 1e-24;
/// The coarsest grid of vertices that is still exact enough, m. STL and OBJ files are read in
/// single precision.
const GRID_MAX: f64 = 5e-4;
/// Corners of a face further off its plane leave open where its surface is, m.
const OFF_PLANE_MAX: f64 = 1e-3;

impl MeshSource {
    /// The vertices of the file's triangles, scaled, as they are in the file.
    ///
    /// # Errors
    /// The file cannot be read, or is no mesh.
    pub fn vertices(&self) -> Result<Vec<DVec3>, String> {
        Ok(MeshStore::default().scaled(&self.path, self.scale)?.0)
    }
}

/// Meshes by file, each read once, with the digests of all of them in the order of first use.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    files: BTreeMap<PathBuf, RawMesh>,
    digests: Vec<Digest>,
}

impl MeshStore {
    /// The surface in a file, scaled. A mirroring scale keeps its normals outward.
    pub(crate) fn surface(&mut self, path: &Path, scale: DVec3) -> Result<Shape, String> {
        let (vertices, mut triangles) = self.scaled(path, scale)?;
        self.check_flat_faces(path, scale)?;
        if scale.x * scale.y * scale.z < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        triangles.retain(|triangle| has_area(triangle.map(|index| vertices[index as usize])));
        if triangles.is_empty() {
            return Err(format!("mesh {} has no triangle of any area", path.display()));
        }
        let source = Some(MeshSource { path: absolute(path), scale });
        Ok(Shape::Mesh { vertices, triangles, source })
    }

    /// Whether a file holds any triangles. CAD programs write files without for frames.
    pub(crate) fn has_triangles(&mut self, path: &Path) -> Result<bool, String> {
        Ok(!self.load(path)?.triangles.is_empty())
    }

    /// The convex hull of a file's triangles, scaled.
    pub(crate) fn hull(&mut self, path: &Path, scale: DVec3) -> Result<Shape, String> {
        let (vertices, _) = self.scaled(path, scale)?;
        let points = hull_points(vertices)
            .map_err(|message| format!("mesh {}: {message}", path.display()))?;
        let source = Some(MeshSource { path: absolute(path), scale });
        Ok(Shape::ConvexHull { points, source })
    }

    /// The files read so far, sorted.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        self.files.keys().map(|path| absolute(path)).collect()
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
        if mesh.triangles.is_empty() {
            return Err(format!("mesh {} holds no triangles", path.display()));
        }
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|vertex| *vertex * scale).collect();
        let farthest = vertices.iter().map(|vertex| vertex.abs().max_element()).fold(0.0, f64::max);
        if farthest > NUMBER_MAX {
            return Err(format!(
                "mesh {} has a vertex at {farthest} m, beyond {NUMBER_MAX:e} m{}",
                path.display(),
                question(scale)
            ));
        }
        if mesh.is_single && farthest * f64::from(f32::EPSILON) > GRID_MAX {
            return Err(format!(
                "mesh {} reaches {farthest} m from its origin, where single precision is too coarse{}; if metres are meant, move it there and give the shape a pose",
                path.display(),
                question(scale)
            ));
        }
        Ok((vertices, mesh.triangles.clone()))
    }

    /// Refuses a face that has no surface because it is no plane polygon.
    fn check_flat_faces(&mut self, path: &Path, scale: DVec3) -> Result<(), String> {
        let Some(BentFace { off_plane, line }) = &self.load(path)?.most_bent else { return Ok(()) };
        let off_plane = off_plane * scale.abs().max_element();
        if off_plane <= OFF_PLANE_MAX {
            return Ok(());
        }
        let how = if off_plane.is_finite() {
            format!("with corners {:.1} mm off its plane", 1e3 * off_plane)
        } else {
            "whose outline crosses itself".into()
        };
        let line = line.map(|line| format!(":{line}")).unwrap_or_default();
        Err(format!("mesh {}{line} has a face {how}; export it as triangles", path.display()))
    }

    fn load(&mut self, path: &Path) -> Result<&RawMesh, String> {
        if !self.files.contains_key(path) {
            let in_file = |MeshError { line, message }: MeshError| match line {
                Some(line) => format!("mesh {}:{line} {message}", path.display()),
                None => format!("mesh {} {message}", path.display()),
            };
            let bytes =
                read_bytes(path, MESH_BYTES_MAX).map_err(|message| in_file(message.into()))?;
            let mesh = parse(path, &bytes).map_err(in_file)?;
            self.digests.push(Digest::of(&[&bytes]));
            self.files.insert(path.to_owned(), mesh);
        }
        Ok(&self.files[path])
    }
}

/// The surface of triangles in memory (m, counter-clockwise seen from outside).
pub(crate) fn mesh_from_memory(
    triangles: impl Iterator<Item = Result<[DVec3; 3], String>>,
) -> Result<Shape, String> {
    let mut welder = Welder::default();
    for corners in triangles {
        welder.push(corners?)?;
    }
    let RawMesh { vertices, mut triangles, .. } = welder.mesh;
    triangles.retain(|triangle| has_area(triangle.map(|index| vertices[index as usize])));
    if triangles.is_empty() {
        return Err("has no triangle of any area".to_owned());
    }
    Ok(Shape::Mesh { vertices, triangles, source: None })
}

/// The longest side of the box around points.
pub(crate) fn extent(points: &[DVec3]) -> f64 {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    (high - low).max_element()
}

/// Asks whether a file that comes out huge is in millimetres.
fn question(scale: DVec3) -> &'static str {
    if scale == DVec3::ONE { ": millimetres? set scale = 0.001" } else { ": is its scale right?" }
}

/// The content of a file.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut welder = Welder::default();
    let format = format_of(path, bytes)?;
    welder.mesh.is_single = format != Format::Collada;
    let read = match format {
        Format::Stl => stl::read(bytes, &mut welder),
        Format::Obj => obj::read(bytes, &mut welder),
        Format::Collada => collada::read(bytes, &mut welder),
    };
    // What a file is says more than where it differs from what its name says.
    let foreign = || foreign(path, bytes).filter(|_| format != Format::Stl || !stl::is_text(bytes));
    read.map_err(|error| foreign().map_or(error, MeshError::from))?;
    Ok(welder.mesh)
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a).length_squared() > DOUBLE_AREA_SQUARED_MIN
}
