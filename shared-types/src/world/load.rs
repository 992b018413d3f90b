//! Reads and validates worlds: TOML world files and the scene of a plan file.

use std::collections::BTreeSet;
use std::path::Path;

use crate::base::digest::Digest;
use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::text_file::{FileLocation, TEXT_BYTES_MAX, TextFile};
use crate::geometry::shape::Shape;
use crate::mesh::store::{MeshStore, extent};
use crate::mesh::undersides::remove_undersides;
use crate::plan_format::blocks::{SceneBlock, SceneShapeBlock, ShapeBlock};

use crate::world::shape_block::{pose_from_block, shape_from_block};
use crate::world::world::{World, WorldShape};
use crate::world::world_file::RawWorld;

/// The smallest coefficient of friction that is not 0: on less, a step takes minutes. Wet ice has
/// 0.02.
pub(crate) const MU_MIN: f64 = 0.001;
/// The largest coefficient of friction.
pub(crate) const MU_MAX: f64 = 10.0;
/// A mesh file whose scale is not stated is asked about if it comes out wider than this, m.
const EXTENT_MAX: f64 = 200.0;

/// Loads a world file.
///
/// The file holds `mu` (0, or 0.001 to 10) and a list of `[[shapes]]`, each with a unique `name`, a
/// pose (`xyz`, and `rpy` or `quat_xyzw`; metres and radians, identity by default) and exactly one
/// geometry: `box = { half_extents }`, `sphere = { radius }`, `cylinder = { radius, length }` (full
/// length, along z), `capsule = { radius, length }` (length of the cylindrical part), `convex =
/// { points }` or `convex = { path, scale }`, `mesh = { path, scale }` (one number or three). Paths
/// are relative to the file; docs/FORMATS.md says how STL, OBJ and COLLADA files are read.
///
/// # Errors
/// When the file cannot be read or anything in it is out of order: the first such thing, with its
/// line.
pub fn load_world(path: &Path) -> Result<World, InputError> {
    let source = TextFile::read(path, FileKind::World, TEXT_BYTES_MAX)?;
    let raw: RawWorld = source.parse_toml(FileKind::World)?;
    let mu_location = source.location(raw.mu.span().start);
    let mut builder = WorldBuilder::new(path.parent().unwrap_or(Path::new("")));
    for shape in raw.shapes {
        let location = source.location(shape.span().start);
        let shape = shape.into_inner();
        let element = format!("shape '{}'", shape.name);
        let block = shape.into_block().map_err(|message| location.error(element, message))?;
        builder.push(&block, &location)?;
        check_unit(&block.shape, builder.shapes.last())
            .map_err(|message| location.error(format!("shape '{}'", block.name), message))?;
    }
    builder.finish(raw.mu.into_inner(), &mu_location, source.text.as_bytes())
}

/// Builds the world that a plan file carries. Mesh paths are relative to `base_dir`; errors name
/// `plan_path`.
///
/// # Errors
/// The first thing in the block that is out of order.
pub fn world_from_block(
    block: &SceneBlock,
    base_dir: &Path,
    plan_path: &Path,
) -> Result<World, InputError> {
    let location = FileLocation::file(plan_path);
    let bytes = serde_json::to_vec(block)
        .map_err(|error| InputError::element(plan_path, "scene", error.to_string()))?;
    let mut builder = WorldBuilder::new(base_dir);
    for shape in &block.shapes {
        builder.push(shape, &location)?;
    }
    builder.finish(block.mu, &location, &bytes)
}

/// Asks about a mesh file of which the scale is not stated and the extent is that of no location a
/// robot walks through.
fn check_unit(block: &ShapeBlock, loaded: Option<&WorldShape>) -> Result<(), String> {
    let (ShapeBlock::Mesh { path, scale: None }
    | ShapeBlock::Convex { path: Some(path), scale: None, .. }) = block
    else {
        return Ok(());
    };
    let Some(Shape::Mesh { vertices: points, .. } | Shape::ConvexHull { points, .. }) =
        loaded.map(|shape| &shape.shape)
    else {
        return Ok(());
    };
    let extent = extent(points);
    if extent <= EXTENT_MAX {
        return Ok(());
    }
    Err(format!(
        "mesh {path} is {extent:.0} m across: millimetres? set scale = 0.001 (scale = 1 if metres are meant)"
    ))
}

/// Whether a number is a coefficient of friction on which a robot can walk, or 0.
pub(crate) fn is_friction(mu: f64) -> bool {
    mu == 0.0 || (MU_MIN..=MU_MAX).contains(&mu)
}

struct WorldBuilder<'a> {
    base_dir: &'a Path,
    meshes: MeshStore,
    names: BTreeSet<String>,
    shapes: Vec<WorldShape>,
}

impl<'a> WorldBuilder<'a> {
    fn new(base_dir: &'a Path) -> Self {
        Self { base_dir, meshes: MeshStore::default(), names: BTreeSet::new(), shapes: Vec::new() }
    }

    fn push(&mut self, block: &SceneShapeBlock, location: &FileLocation) -> Result<(), InputError> {
        let shape = self
            .shape(block)
            .map_err(|message| location.error(format!("shape '{}'", block.name), message))?;
        self.shapes.push(shape);
        Ok(())
    }

    fn shape(&mut self, block: &SceneShapeBlock) -> Result<WorldShape, String> {
        if block.name.trim().is_empty() {
            return Err(format!("shape {} needs a name", self.shapes.len()));
        }
        if !self.names.insert(block.name.clone()) {
            return Err("another shape has the same name".into());
        }
        let world_from_shape = pose_from_block(&block.pose)?;
        let mut shape = shape_from_block(&block.shape, self.base_dir, &mut self.meshes)?;
        if let Shape::Mesh { vertices, triangles, .. } = &mut shape {
            remove_undersides(vertices, triangles, world_from_shape.rotation);
        }
        Ok(WorldShape { name: block.name.clone(), world_from_shape, shape })
    }

    fn finish(
        self,
        mu: f64,
        mu_location: &FileLocation,
        bytes: &[u8],
    ) -> Result<World, InputError> {
        if !is_friction(mu) {
            let range = format!("{MU_MIN} and {MU_MAX}, or is 0");
            return Err(mu_location
                .error("mu", format!("is {mu}; a coefficient of friction lies between {range}")));
        }
        if self.shapes.is_empty() {
            return Err(mu_location.error("shapes", "a world needs at least one shape to stand on"));
        }
        let digest = Digest::of(&[bytes, &self.meshes.digest().0]);
        Ok(World { mu, shapes: self.shapes, digest })
    }
}
