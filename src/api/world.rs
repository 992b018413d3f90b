//! A world: fixed shapes with one coefficient of friction.

use std::path::Path;
use std::sync::Arc;

use surefoot_shared_types::plan_format::blocks::ShapeBlock;
use surefoot_shared_types::world::builder::{Geometry, NamedGeometry, build_world};
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World as WorldModel;

use crate::api::error::{LoadError, WorldError};
use crate::api::height_map::HeightMap;
use crate::api::pose::Pose;

/// Friction of a world for which none is set.
const FRICTION_DEFAULT: f64 = 0.6;

/// A validated world. Gravity is 9.81 m/s² along -z. Cheap to clone.
#[derive(Debug, Clone)]
pub struct World {
    model: Arc<WorldModel>,
}

impl World {
    /// Loads a world file (TOML) with the meshes that it names.
    ///
    /// # Errors
    /// A file cannot be read, or something in it is out of order: file, line and element are named.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(Self::new(load_world(path.as_ref())?))
    }

    /// Begins a world in memory.
    ///
    /// # Examples
    /// ```
    /// use surefoot::{Pose, Shape, World};
    ///
    /// let stone = Shape::cylinder(0.15, 0.4);
    /// let world = World::builder()
    ///     .friction(0.7)
    ///     .shape("stone", Pose::at(0.4, 0.0, -0.2), stone)
    ///     .build()?;
    /// assert_eq!(world.shape_names().collect::<Vec<_>>(), ["stone"]);
    /// # Ok::<(), surefoot::WorldError>(())
    /// ```
    pub fn builder() -> WorldBuilder {
        WorldBuilder { friction: FRICTION_DEFAULT, shapes: vec![] }
    }

    /// The names of the shapes, in their order.
    pub fn shape_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.model.shapes.iter().map(|shape| shape.name.as_str())
    }

    /// Wraps a validated world.
    pub(crate) fn new(model: WorldModel) -> Self {
        Self { model: Arc::new(model) }
    }

    /// The coefficient of friction.
    pub fn friction(&self) -> f64 {
        self.model.mu
    }

    /// The validated world, for the crates of this repository.
    #[doc(hidden)]
    pub fn model(&self) -> &WorldModel {
        &self.model
    }
}

/// A convex solid in its own frame, centred on the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape(ShapeBlock);

impl Shape {
    /// A box with half of each side, m.
    pub fn cuboid(half_extents: [f64; 3]) -> Self {
        Self(ShapeBlock::Box { half_extents })
    }

    /// A ball with its radius, m.
    pub fn sphere(radius: f64) -> Self {
        Self(ShapeBlock::Sphere { radius })
    }

    /// A cylinder along z with its radius and its full length, m.
    pub fn cylinder(radius: f64, length: f64) -> Self {
        Self(ShapeBlock::Cylinder { radius, length })
    }

    /// A capsule along z with its radius and the length of its cylindrical part, m.
    pub fn capsule(radius: f64, length: f64) -> Self {
        Self(ShapeBlock::Capsule { radius, length })
    }

    /// The convex hull of points (m) that span a volume.
    pub fn convex(points: &[[f64; 3]]) -> Self {
        Self(ShapeBlock::Convex { points: Some(points.to_vec()), path: None, scale: None })
    }
}

/// Collects the shapes of a world. [`WorldBuilder::build`] validates them.
#[derive(Debug, Clone)]
pub struct WorldBuilder {
    friction: f64,
    shapes: Vec<NamedGeometry>,
}

impl WorldBuilder {
    /// Sets the coefficient of friction of all shapes, 0 to 10; 0.6 by default.
    #[must_use]
    pub fn friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// Adds a shape at a pose in the world. Names are unique.
    #[must_use]
    pub fn shape(self, name: &str, world_from_shape: Pose, shape: Shape) -> Self {
        self.add(name, world_from_shape, Geometry::Block(shape.0))
    }

    /// Adds a triangle mesh: vertices in its own frame (m) and triangles of vertex indices,
    /// counter-clockwise seen from outside.
    #[must_use]
    pub fn mesh(
        self,
        name: &str,
        world_from_mesh: Pose,
        vertices: &[[f64; 3]],
        triangles: &[[u32; 3]],
    ) -> Self {
        let geometry =
            Geometry::Mesh { vertices: vertices.to_vec(), triangles: triangles.to_vec() };
        self.add(name, world_from_mesh, geometry)
    }

    /// Adds the surface of a height map.
    #[must_use]
    pub fn height_map(self, name: &str, world_from_map: Pose, map: &HeightMap<'_>) -> Self {
        let (vertices, triangles) = map.surface();
        self.mesh(name, world_from_map, &vertices, &triangles)
    }

    fn add(mut self, name: &str, world_from_shape: Pose, geometry: Geometry) -> Self {
        self.shapes.push(NamedGeometry {
            name: name.to_owned(),
            world_from_shape: world_from_shape.into(),
            geometry,
        });
        self
    }

    /// Validates all shapes.
    ///
    /// # Errors
    /// The first shape that is out of order, by its name.
    pub fn build(self) -> Result<World, WorldError> {
        Ok(World::new(build_world(self.friction, &self.shapes)?))
    }
}
