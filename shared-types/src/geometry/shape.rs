//! Shapes of robots and worlds.

use glam::DVec3;

/// A solid in its own frame, lengths in m. A mesh is a closed surface with outward normals.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A box centred on the origin.
    Box {
        /// Half of each side length.
        half_extents: DVec3,
    },
    /// A sphere centred on the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A cylinder along z, centred on the origin.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Half of its length.
        half_length: f64,
    },
    /// A capsule along z, centred on the origin.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Half of the length of its cylindrical part.
        half_length: f64,
    },
    /// The convex hull of some points.
    ConvexHull {
        /// At least four points that span a volume; interior points are allowed.
        points: Vec<DVec3>,
        /// The mesh file of which it is the hull; `None` for points that are stated.
        source: Option<MeshSource>,
    },
    /// A triangle mesh.
    Mesh {
        /// Its vertices.
        vertices: Vec<DVec3>,
        /// Vertex indices, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
        /// The mesh file, which an exported plan names; `None` for a mesh in memory.
        source: Option<MeshSource>,
    },
}

/// The file of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSource {
    /// Absolute path of the file.
    pub path: std::path::PathBuf,
    /// The scale factors of its vertices along x, y and z.
    pub scale: DVec3,
}
