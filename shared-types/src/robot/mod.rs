//! Robots: URDF and robot file, and the validated model.

pub(crate) mod exact_meshes;
pub(crate) mod joints;
pub(crate) mod links;
pub mod load;
pub mod model;
pub(crate) mod robot_file;
pub(crate) mod sole;
pub(crate) mod spec;
pub(crate) mod tree;
pub(crate) mod urdf;
