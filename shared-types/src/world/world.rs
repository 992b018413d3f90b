//! A world: fixed shapes with one coefficient of friction. The robot may step on any of them.

use crate::base::digest::Digest;
use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;

/// A validated world. Gravity is [`GRAVITY`] along -z.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// The coefficient of friction of all contacts, 0 to 10.
    pub mu: f64,
    /// The shapes, in file order.
    pub shapes: Vec<WorldShape>,
    /// Digest of the world file and its meshes.
    pub digest: Digest,
}

/// A fixed shape.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldShape {
    /// Its name, unique in the world.
    pub name: String,
    /// The pose of the shape in the world.
    pub world_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
}

/// Gravity as the plan format defines it, m/s2.
pub const GRAVITY: f64 = 9.81;
