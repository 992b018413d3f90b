//! A world: fixed shapes with one coefficient of friction. Nothing says which of them may be walked
//! on.

use crate::base::digest::Digest;
use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;

/// A validated world. Gravity is 9.81 m/s2 along -z.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// The coefficient of friction of everything, 0 to 10.
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
    /// The shape's frame in the world's.
    pub world_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
}

/// Standard gravity as the plan format fixes it, m/s2.
pub const GRAVITY: f64 = 9.81;
