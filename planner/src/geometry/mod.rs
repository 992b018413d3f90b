//! Shapes, distances and polygons, independent of any robot.

pub(crate) mod bvh;
pub(crate) mod convex_hull;
pub mod convex_region;
pub(crate) mod coplanar_faces;
mod depth;
pub(crate) mod distance;
pub mod narrow_phase;
pub(crate) mod polygon;
pub(crate) mod resting_foot;
pub mod shape_error;
pub mod solid;
pub(crate) mod tessellation;
pub(crate) mod triangle_mesh;
mod tuning;
pub(crate) mod voxel_grid;
