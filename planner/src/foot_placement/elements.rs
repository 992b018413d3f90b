//! The elements of a compiled world: flat faces and curved surfaces.

use glam::DVec3;

/// A planar convex piece of the boundary of a shape.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// Outward unit normal.
    pub normal: DVec3,
    /// `normal . p` of its points, m.
    pub offset: f64,
    /// Index of its first vertex in the world's list of vertices.
    pub first: u32,
    /// Number of vertices, at most
    /// [`FACE_VERTICES_MAX`](crate::geometry::polygon::FACE_VERTICES_MAX).
    pub count: u32,
    /// Whether it belongs to a mesh, so that other faces may continue it in its plane.
    pub of_mesh: bool,
}

/// How a curved shape ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SurfaceEnds {
    /// A cylinder: the flat caps and the side are also faces, for collision.
    Flat,
    /// A capsule or a ball.
    Spherical,
}

/// The side of a cylinder, a capsule, or a ball (`a == b`).
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvedSurface {
    /// One end of the axis.
    pub a: DVec3,
    /// The other end.
    pub b: DVec3,
    /// The radius, m.
    pub radius: f64,
    /// Its ends.
    pub ends: SurfaceEnds,
}

impl CurvedSurface {
    /// The axis direction, or `None` for a ball.
    pub fn direction(&self) -> Option<DVec3> {
        (self.b - self.a).try_normalize()
    }

    /// The line of the side with this unit normal, from end to end.
    pub fn line_with_normal(&self, side_normal: DVec3) -> [DVec3; 2] {
        [self.a, self.b].map(|end| end + side_normal * self.radius)
    }

    /// The unit normal of the side nearest to `normal`, or `None` where the axis is along it.
    pub fn side_normal(&self, normal: DVec3) -> Option<DVec3> {
        match self.direction() {
            None => Some(normal),
            Some(d) => (normal - d * normal.dot(d)).try_normalize(),
        }
    }
}

/// One element of the compiled world.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Element<'a> {
    /// A face and its vertices, counter-clockwise seen from outside.
    Face(&'a Face, &'a [DVec3]),
    /// A curved surface.
    Curved(&'a CurvedSurface),
}
