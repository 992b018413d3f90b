//! The checker's geometry: solids as support functions, separating directions, ray casts, plane
//! polygons.

pub mod body;
pub mod bounds;
pub mod polygon;
pub mod rays;
pub mod separation;
pub mod solid;
