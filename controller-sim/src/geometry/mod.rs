//! Solids as support functions, separating directions, ray casts, polygons in a plane.

pub(crate) mod body;
pub(crate) mod bounds;
pub(crate) mod hull;
pub(crate) mod mesh_solid;
pub(crate) mod penetration;
pub mod polygon;
pub(crate) mod rays;
pub(crate) mod separation;
pub(crate) mod solid;
