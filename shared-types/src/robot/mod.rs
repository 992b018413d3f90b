//! Robots: URDF and robot file, and the validated model.

pub(crate) mod element;
pub mod exact_meshes;
pub(crate) mod feet;
pub(crate) mod joints;
pub(crate) mod links;
pub mod load;
pub(crate) mod merge;
pub(crate) mod mesh_path;
pub(crate) mod mesh_size;
pub mod model;
pub(crate) mod robot_file;
pub(crate) mod sole;
pub(crate) mod spec;
pub(crate) mod spec_check;
pub(crate) mod surface_points;
pub(crate) mod tree;
pub(crate) mod turned_root;
pub(crate) mod urdf;
pub(crate) mod urdf_joint;
pub(crate) mod urdf_link;
pub mod urdf_order;
