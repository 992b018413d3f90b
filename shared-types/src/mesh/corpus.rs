//! Compares a corpus of mesh files with other readers: tobj for OBJ, stl_io for STL. It runs where
//! `SUREFOOT_MESH_CORPUS` names a folder of meshes.

#![allow(clippy::unwrap_used, reason = "helpers of tests, not input handling")]

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::mesh::raw_mesh::RawMesh;
use crate::mesh::store::parse;

/// Triangles by their corners.
type Triangles = Vec<[DVec3; 3]>;

/// What another reader finds.
struct Reference {
    /// Distinct vertices of faces.
    vertices: usize,
    /// Triangles, faces cut as fans.
    triangles: usize,
    area: f64,
}

#[test]
fn a_corpus_has_the_vertices_and_faces_that_other_readers_find() {
    let Some(corpus) = std::env::var_os("SUREFOOT_MESH_CORPUS") else {
        println!("skipped: SUREFOOT_MESH_CORPUS names no folder");
        return;
    };
    let (mut compared, mut refused) = (0, 0);
    for path in files_below(PathBuf::from(corpus)) {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let reference = match ending.as_str() {
            "obj" => obj_reference(&path),
            "stl" => stl_reference(&path),
            "dae" => None,
            _ => continue,
        };
        match (parse(&path, &std::fs::read(&path).unwrap()), reference) {
            (Ok(mesh), Some(reference)) => {
                assert_alike(&path, &mesh, &reference);
                compared += 1;
            }
            (Err(error), reference) => {
                println!(
                    "refused, {} elsewhere: {}: {error:?}",
                    if reference.is_some() { "read" } else { "refused" },
                    path.display()
                );
                refused += 1;
            }
            (Ok(_), None) => println!("read here only: {}", path.display()),
        }
    }
    println!("{compared} compared, {refused} refused");
    assert!(compared > 0, "SUREFOOT_MESH_CORPUS holds no mesh");
}

fn assert_alike(path: &Path, mesh: &RawMesh, reference: &Reference) {
    let corners = mesh.triangles.iter().map(|of| of.map(|at| mesh.vertices[at as usize]));
    let whole: f64 = corners.map(|of| area(&[of]).length()).sum();
    let name = path.display();
    assert_eq!(mesh.vertices.len(), reference.vertices, "vertices of {name}");
    assert_eq!(mesh.triangles.len(), reference.triangles, "triangles of {name}");
    let error = (whole - reference.area).abs();
    // The area of a bent face depends on how it is cut.
    let tolerance = if mesh.most_bent.is_some() { 5e-2 } else { 1e-6 };
    assert!(error <= tolerance * reference.area, "{name}: {whole}, not {}", reference.area);
}

fn files_below(folder: PathBuf) -> Vec<PathBuf> {
    let (mut files, mut ahead) = (Vec::new(), vec![folder]);
    while let Some(path) = ahead.pop() {
        if path.is_dir() {
            ahead.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn area(triangles: &[[DVec3; 3]]) -> DVec3 {
    triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum()
}

fn distinct(corners: impl Iterator<Item = DVec3>) -> usize {
    let places = corners.map(|corner| (corner + DVec3::ZERO).to_array().map(f64::to_bits));
    places.collect::<std::collections::BTreeSet<_>>().len()
}

/// By tobj. The area of a plane face does not depend on how it is cut.
fn obj_reference(path: &Path) -> Option<Reference> {
    let options = tobj::LoadOptions { triangulate: false, ..Default::default() };
    let text = std::fs::read(path).unwrap();
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_slice(), &options, no_materials).ok()?;
    let mut faces: Vec<Vec<DVec3>> = Vec::new();
    for mesh in models.iter().map(|model| &model.mesh) {
        let corner = |at: &u32| {
            let [x, y, z] = [0, 1, 2].map(|axis| mesh.positions[3 * *at as usize + axis]);
            DVec3::new(x.into(), y.into(), z.into())
        };
        let mut indices = &mesh.indices[..];
        let threes = vec![3; mesh.indices.len() / 3];
        let sizes = if mesh.face_arities.is_empty() { &threes } else { &mesh.face_arities };
        for size in sizes {
            let (face, rest) = indices.split_at(*size as usize);
            indices = rest;
            faces.push(face.iter().map(corner).collect());
        }
    }
    // Lines and points are faces of fewer corners there.
    faces.retain(|face| face.len() > 2);
    let fan = |face: &Vec<DVec3>| -> Triangles {
        face[1..].windows(2).map(|of| [face[0], of[0], of[1]]).collect()
    };
    Some(Reference {
        vertices: distinct(faces.iter().flatten().copied()),
        triangles: faces.iter().map(|face| face.len() - 2).sum(),
        area: faces.iter().map(|face| area(&fan(face)).length()).sum(),
    })
}

fn stl_reference(path: &Path) -> Option<Reference> {
    let mesh = stl_io::read_stl(&mut std::fs::File::open(path).unwrap()).ok()?;
    let corner = |at: usize| DVec3::from_array(mesh.vertices[at].0.map(f64::from));
    let faces: Triangles = mesh.faces.iter().map(|face| face.vertices.map(corner)).collect();
    Some(Reference {
        vertices: distinct(faces.as_flattened().iter().copied()),
        triangles: faces.len(),
        area: faces.iter().map(|face| area(&[*face]).length()).sum(),
    })
}
