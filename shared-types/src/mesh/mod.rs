//! Triangle meshes from files: STL, OBJ and COLLADA.

pub(crate) mod accessor;
pub(crate) mod collada;
pub(crate) mod collada_geometry;
pub(crate) mod collada_xml;
#[cfg(test)]
mod corpus;
pub(crate) mod file_name;
pub(crate) mod format;
pub(crate) mod obj;
pub(crate) mod polygon;
pub(crate) mod raw_mesh;
pub(crate) mod stl;
pub(crate) mod store;
pub(crate) mod undersides;
