//! mesh.

pub(crate) mod collada;
pub(crate) mod collada_geometry;
pub(crate) mod store;
