//! geometry.

pub(crate) mod convex_hull;
pub mod shape;
