//! Worlds from shapes in memory: no file needed.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;

use crate::base::digest::Digest;
use crate::geometry::shape::Shape;
use crate::mesh::store::{MeshStore, mesh_from_memory};
use crate::plan_format::blocks::{PoseBlock, ShapeBlock};
use crate::world::load::{MU_MAX, MU_MIN, is_friction};
use crate::world::shape_block::{pose_from_block, shape_from_block};
use crate::world::world::{World, WorldShape};

/// Why a world cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The coefficient of friction is out of range.
    #[error("the coefficient of friction is {0}; it lies between {MU_MIN} and {MU_MAX}, or is 0")]
    Friction(f64),
    /// There is no shape.
    #[error("a world needs at least one shape to stand on")]
    Empty,
    /// A shape cannot be used.
    #[error("shape '{name}': {problem}")]
    Shape {
        /// The shape's name.
        name: String,
        /// The error.
        problem: String,
    },
}

/// The geometry of a shape in memory.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// A primitive, or the convex hull of points. No paths.
    Block(ShapeBlock),
    /// A triangle mesh: vertices (m) and vertex indices, counter-clockwise seen from outside.
    Mesh {
        /// The vertices.
        vertices: Vec<[f64; 3]>,
        /// The triangles.
        triangles: Vec<[u32; 3]>,
    },
}

/// A named shape and its pose.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedGeometry {
    /// Its name, unique in the world.
    pub name: String,
    /// The shape's frame in the world's.
    pub world_from_shape: PoseBlock,
    /// The shape.
    pub geometry: Geometry,
}

/// Builds a world from shapes, with the rules of a world file. Equal shapes have equal digests.
///
/// # Errors
/// The first thing that is out of order.
pub fn build_world(mu: f64, shapes: &[NamedGeometry]) -> Result<World, WorldError> {
    if !is_friction(mu) {
        return Err(WorldError::Friction(mu));
    }
    if shapes.is_empty() {
        return Err(WorldError::Empty);
    }
    let (mut names, mut built) = (BTreeSet::new(), Vec::with_capacity(shapes.len()));
    let mut digest = Digest::of(&[&mu.to_le_bytes()]);
    for shape in shapes {
        let in_shape = |problem| WorldError::Shape { name: shape.name.clone(), problem };
        if shape.name.trim().is_empty() {
            return Err(in_shape(format!("shape {} needs a name", built.len())));
        }
        if !names.insert(&shape.name) {
            return Err(in_shape("another shape has the same name".to_owned()));
        }
        built.push(build_shape(shape).map_err(in_shape)?);
        digest = digest.chain(&content(shape));
    }
    Ok(World { mu, shapes: built, digest })
}

fn build_shape(shape: &NamedGeometry) -> Result<WorldShape, String> {
    let world_from_shape = pose_from_block(&shape.world_from_shape)?;
    let solid = match &shape.geometry {
        Geometry::Block(ShapeBlock::Mesh { .. } | ShapeBlock::Convex { path: Some(_), .. }) => {
            return Err("a shape in memory names no file".to_owned());
        }
        Geometry::Block(block) => {
            shape_from_block(block, Path::new(""), &mut MeshStore::default())?
        }
        Geometry::Mesh { vertices, triangles } => mesh(vertices, triangles)?,
    };
    Ok(WorldShape { name: shape.name.clone(), world_from_shape, shape: solid })
}

fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Shape, String> {
    let corner = |index: u32| {
        let vertex = vertices.get(index as usize).copied().map(DVec3::from_array);
        vertex.ok_or_else(|| format!("has a triangle with vertex {index} of {}", vertices.len()))
    };
    let corners = triangles.iter().map(|[a, b, c]| Ok([corner(*a)?, corner(*b)?, corner(*c)?]));
    mesh_from_memory(corners)
}

/// The bytes of a shape that count for the world's digest.
fn content(shape: &NamedGeometry) -> Vec<u8> {
    let numbers = |vertices: &[[f64; 3]]| -> Vec<u8> {
        vertices.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
    };
    let geometry = match &shape.geometry {
        Geometry::Block(block) => json(block),
        Geometry::Mesh { vertices, triangles } => {
            let mut bytes = numbers(vertices);
            bytes.extend(triangles.iter().flatten().flat_map(|index| index.to_le_bytes()));
            bytes
        }
    };
    [shape.name.clone().into_bytes(), json(&shape.world_from_shape), geometry]
        .into_iter()
        .flat_map(|part| [(part.len() as u64).to_le_bytes().to_vec(), part])
        .flatten()
        .collect()
}

fn json(block: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(block).expect("blocks of plain numbers can always be written as JSON")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor() -> NamedGeometry {
        NamedGeometry {
            name: "floor".into(),
            world_from_shape: PoseBlock { xyz: [0.0, 0.0, -0.5], quat_xyzw: [0.0, 0.0, 0.0, 1.0] },
            geometry: Geometry::Block(ShapeBlock::Box { half_extents: [2.0, 1.0, 0.5] }),
        }
    }

    fn triangle(vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> NamedGeometry {
        NamedGeometry { geometry: Geometry::Mesh { vertices, triangles }, ..floor() }
    }

    #[test]
    fn a_world_in_memory_is_that_of_its_shapes() {
        let world = build_world(0.6, &[floor()]).unwrap();
        assert_eq!(world.shapes[0].shape, Shape::Box { half_extents: DVec3::new(2.0, 1.0, 0.5) });
        assert_eq!(world.digest, build_world(0.6, &[floor()]).unwrap().digest);
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = build_world(0.6, &[triangle(corners, vec![[0, 1, 2]])]).unwrap();
        assert!(
            matches!(&mesh.shapes[0].shape, Shape::Mesh { triangles, .. } if triangles.len() == 1)
        );
        assert_ne!(world.digest, mesh.digest);
    }

    #[test]
    fn an_invalid_shape_is_named() {
        for mu in [-1.0, 0.0009, 10.1] {
            assert_eq!(build_world(mu, &[floor()]), Err(WorldError::Friction(mu)));
        }
        assert!(build_world(f64::NAN, &[floor()]).is_err());
        for mu in [0.0, MU_MIN, MU_MAX] {
            assert_eq!(build_world(mu, &[floor()]).map(|world| world.mu), Ok(mu));
        }
        assert_eq!(build_world(0.6, &[]), Err(WorldError::Empty));
        let problem = |shapes: &[NamedGeometry]| match build_world(0.6, shapes).unwrap_err() {
            WorldError::Shape { problem, .. } => problem,
            other => panic!("{other}"),
        };
        assert!(problem(&[floor(), floor()]).contains("same name"));
        assert!(problem(&[triangle(vec![[0.0; 3]], vec![[0, 1, 2]])]).contains("vertex 1 of 1"));
        let nan = vec![[f64::NAN; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(problem(&[triangle(nan, vec![[0, 1, 2]])]).contains("not finite"));
    }
}
