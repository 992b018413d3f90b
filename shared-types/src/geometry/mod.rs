//! Shapes of robots and worlds, and convex hulls.

pub(crate) mod convex_hull;
pub mod shape;
