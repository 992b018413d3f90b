//! The elements of a compiled world: flat faces and curved surfaces.

use glam::{DVec2, DVec3};

use crate::geometry::polygon::closest_on_segment;

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
    /// What it is a piece of.
    pub kind: FaceKind,
}

/// What a face is a piece of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FaceKind {
    /// A flat side of a solid, or a part of it.
    Solid,
    /// A mesh: other faces may continue it in its plane.
    Mesh,
    /// The side of a cylinder: it lies inside the curved surface, which is the ground there.
    CylinderSide,
    /// The end of a cylinder.
    CylinderCap,
}

impl Face {
    /// Whether it belongs to a mesh.
    pub fn of_mesh(&self) -> bool {
        self.kind == FaceKind::Mesh
    }

    /// The height of the face's plane at a place seen from above, m.
    pub fn height_at(&self, at: DVec2) -> f64 {
        (self.offset - self.normal.x * at.x - self.normal.y * at.y) / self.normal.z.max(1e-6)
    }
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

    /// The point of the axis nearest to a place, both seen from above.
    pub fn nearest_on_axis(&self, from: DVec2) -> DVec2 {
        closest_on_segment(self.a.truncate(), self.b.truncate(), from)
    }

    /// The point above a point of the axis seen from above, as high as the radius over it.
    pub fn top_at(&self, near: DVec2) -> DVec3 {
        let (a, b) = (self.a.truncate(), self.b.truncate());
        let length = (b - a).length();
        let share = if length < 1e-12 { 0.0 } else { (near - a).length() / length };
        near.extend(self.a.z + share * (self.b.z - self.a.z) + self.radius)
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
