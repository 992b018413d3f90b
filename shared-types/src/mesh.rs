//! Triangle meshes from STL, OBJ and COLLADA files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::digest::Digest;
use crate::hull::hull_points;
use crate::shape::MeshSource;
use crate::source::{NUMBER_MAX, absolute, check_xml_depth, read_bytes};
use crate::{Shape, source};

/// Largest mesh file, bytes.
const MESH_BYTES_MAX: u64 = 1 << 30;
/// Triangles of less than twice this area (m2, squared) are dropped.
const DOUBLE_AREA_SQUARED_MIN: f64 = 1e-24;

/// Meshes by file, each read once, with the digests of all of them in the order of first use.
#[derive(Debug, Default)]
pub(crate) struct MeshStore {
    files: BTreeMap<PathBuf, RawMesh>,
    digests: Vec<Digest>,
}

#[derive(Debug, Default)]
struct RawMesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
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
        let points = hull_points(vertices).map_err(|message| format!("mesh {}: {message}", path.display()))?;
        Ok(Shape::ConvexHull { points })
    }

    /// The digest of all files read so far.
    pub(crate) fn digest(&self) -> Digest {
        self.digests.iter().fold(Digest::default(), |all, one| all.chain(&one.0))
    }

    fn scaled(&mut self, path: &Path, scale: DVec3) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), String> {
        source::check_numbers("scale", &scale.to_array())?;
        if scale.to_array().contains(&0.0) {
            return Err("scale holds 0; leave it out to keep the file's size".into());
        }
        let mesh = self.load(path)?;
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|vertex| *vertex * scale).collect();
        match vertices.iter().find(|vertex| vertex.abs().max_element() > NUMBER_MAX) {
            Some(vertex) => Err(format!("mesh {} has a vertex at {vertex}, beyond {NUMBER_MAX:e}", path.display())),
            None => Ok((vertices, mesh.triangles.clone())),
        }
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
    check_collada(path, bytes)?;
    let no_side_files = |_: &Path| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
    let parse = || mesh_loader::Loader::default().load_from_slice_with_reader(bytes, path, no_side_files);
    // mesh-loader 0.1.13 indexes out of bounds on some damaged COLLADA files; it holds no state that a panic could harm.
    let scene = std::panic::catch_unwind(parse)
        .map_err(|_| "cannot be parsed: it is damaged".to_owned())?
        .map_err(|error| format!("cannot be parsed: {error}"))?;
    let mut welder = Welder::default();
    for part in &scene.meshes {
        for face in &part.faces {
            welder.push(&part.vertices, *face)?;
        }
    }
    if welder.mesh.triangles.is_empty() {
        return Err("holds no triangles".into());
    }
    Ok(welder.mesh)
}

/// The COLLADA reader recurses, and leaves `up_axis` alone, so only z-up files mean what they say.
fn check_collada(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let extension = path.extension().and_then(std::ffi::OsStr::to_str);
    if matches!(extension, Some("stl" | "STL" | "obj" | "OBJ")) {
        return Ok(());
    }
    let text = std::str::from_utf8(bytes).map_err(|_| "is not STL, OBJ or COLLADA by its name, nor text".to_owned())?;
    check_xml_depth(text).map_err(|(_, message)| message)?;
    if text.contains("<up_axis>Y_UP") || text.contains("<up_axis>X_UP") {
        return Err("is not z-up; export it again with z up".into());
    }
    Ok(())
}

/// Joins vertices at the same place, which STL files repeat for every triangle.
#[derive(Default)]
struct Welder {
    index: BTreeMap<[u32; 3], u32>,
    mesh: RawMesh,
}

impl Welder {
    fn push(&mut self, vertices: &[[f32; 3]], face: [u32; 3]) -> Result<(), String> {
        let mut triangle = [0; 3];
        for (corner, index) in triangle.iter_mut().zip(face) {
            let vertex = vertices.get(index as usize).ok_or_else(|| format!("has a triangle with vertex {index} of {}", vertices.len()))?;
            if vertex.iter().any(|coordinate| !coordinate.is_finite()) {
                return Err(format!("has a vertex that is not finite: {vertex:?}"));
            }
            *corner = self.weld(vertex.map(|coordinate| coordinate + 0.0));
        }
        self.mesh.triangles.push(triangle);
        Ok(())
    }

    fn weld(&mut self, vertex: [f32; 3]) -> u32 {
        let next = self.mesh.vertices.len() as u32;
        *self.index.entry(vertex.map(f32::to_bits)).or_insert_with(|| {
            self.mesh.vertices.push(DVec3::from_array(vertex.map(f64::from)));
            next
        })
    }
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a).length_squared() > DOUBLE_AREA_SQUARED_MIN
}
