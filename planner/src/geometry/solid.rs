//! Shapes in the form that collision checks use: a convex core with a radius, or a triangle mesh.

use glam::DVec3;
use parry3d_f64::shape::SupportMap;
use surefoot_shared_types::{Pose, Shape};

use crate::geometry::bvh::Aabb;
use crate::geometry::convex_hull::Hull;
use crate::geometry::distance::LineSegment;
use crate::geometry::shape_error::ShapeError;
use crate::geometry::triangle_mesh::Mesh;

/// A solid in its own frame.
#[derive(Debug, Clone)]
pub enum Solid {
    /// A convex core with a radius.
    Convex(Convex),
    /// A triangle mesh.
    Mesh(Mesh),
}

/// All points within a radius of a convex core.
#[derive(Debug, Clone)]
pub struct Convex {
    /// The core.
    pub core: Core,
    /// The radius around it, m.
    pub radius: f64,
}

/// A convex set, centred on the origin of its frame unless it has corners of its own.
#[derive(Debug, Clone)]
pub enum Core {
    /// The origin.
    Point,
    /// A segment along z.
    LineSegment {
        /// Half of its length, m.
        half_length: f64,
    },
    /// A box.
    Box {
        /// Half of each side, m.
        half_extents: DVec3,
    },
    /// A cylinder along z.
    Cylinder {
        /// Its radius, m.
        radius: f64,
        /// Half of its length, m.
        half_length: f64,
    },
    /// A convex hull.
    Hull(Hull),
    /// A triangle with these corners.
    Triangle([DVec3; 3]),
}

impl Solid {
    /// Compiles a shape; `owner` names it in errors.
    ///
    /// # Errors
    /// A dimension is not finite and positive, or the hull or mesh is degenerate.
    pub fn new(shape: &Shape, owner: &str) -> Result<Self, ShapeError> {
        let positive = |value: f64, what: &'static str| -> Result<f64, ShapeError> {
            let is_good = value.is_finite() && value > 0.0;
            is_good.then_some(value).ok_or(ShapeError::BadNumber {
                owner: owner.into(),
                what,
                requirement: "finite and positive",
            })
        };
        let (core, radius) = match shape {
            Shape::Box { half_extents } => {
                positive(half_extents.min_element(), "every half extent")?;
                positive(half_extents.max_element(), "every half extent")?;
                (Core::Box { half_extents: *half_extents }, 0.0)
            }
            Shape::Sphere { radius: 0.0 } => (Core::Point, 0.0),
            Shape::Sphere { radius } => (Core::Point, positive(*radius, "the radius")?),
            Shape::Cylinder { radius, half_length } => {
                let (radius, half_length) =
                    (positive(*radius, "the radius")?, positive(*half_length, "the length")?);
                (Core::Cylinder { radius, half_length }, 0.0)
            }
            Shape::Capsule { radius, half_length } => (
                Core::LineSegment { half_length: positive(*half_length, "the length")? },
                positive(*radius, "the radius")?,
            ),
            Shape::ConvexHull { points, .. } => {
                let hull = Hull::new(points)
                    .map_err(|reason| ShapeError::DegenerateHull { owner: owner.into(), reason })?;
                (Core::Hull(hull), 0.0)
            }
            Shape::Mesh { vertices, triangles, .. } => {
                let mesh = Mesh::new(vertices, triangles);
                return mesh
                    .map(Self::Mesh)
                    .map_err(|reason| ShapeError::BadMesh { owner: owner.into(), reason });
            }
        };
        Ok(Self::Convex(Convex { core, radius }))
    }

    /// Bounding box in its frame.
    pub fn aabb(&self) -> Aabb {
        match self {
            Self::Convex(convex) => convex.core.aabb().grown(convex.radius),
            Self::Mesh(mesh) => mesh.aabb(),
        }
    }

    /// A point of the solid.
    pub fn point_inside(&self) -> DVec3 {
        match self {
            Self::Convex(Convex { core: Core::Hull(hull), .. }) => hull.vertices()[0],
            Self::Convex(Convex { core: Core::Triangle(corners), .. }) => corners[0],
            Self::Convex(_) => DVec3::ZERO,
            Self::Mesh(mesh) => mesh.vertices()[0],
        }
    }

    /// The radius of a ball about the centre of its bounding box that the solid contains, m; 0
    /// where the centre is not known to lie inside.
    pub fn inner_radius(&self) -> f64 {
        match self {
            Self::Convex(convex) => convex.core.inner_radius() + convex.radius,
            Self::Mesh(mesh) => mesh.inner_radius(),
        }
    }

    /// The core of a sphere or capsule, placed by `frame`; `None` for other solids.
    pub fn core_segment(&self, frame: &Pose) -> Option<LineSegment> {
        match self {
            Self::Convex(Convex { core: Core::Point, .. }) => {
                Some(LineSegment { start: frame.translation, delta: DVec3::ZERO })
            }
            Self::Convex(Convex { core: Core::LineSegment { half_length }, .. }) => {
                Some(LineSegment::along_z(frame, *half_length))
            }
            _ => None,
        }
    }

    /// Half of each side, if the solid is a box.
    pub fn box_half_extents(&self) -> Option<DVec3> {
        match self {
            Self::Convex(Convex { core: Core::Box { half_extents }, .. }) => Some(*half_extents),
            _ => None,
        }
    }

    /// The radius around the core; 0 for a mesh.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Convex(convex) => convex.radius,
            Self::Mesh(_) => 0.0,
        }
    }

    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Convex(Convex { core: Core::Hull(hull), .. }) => hull.bytes(),
            Self::Convex(_) => 0,
            Self::Mesh(mesh) => mesh.bytes(),
        }
    }
}

impl Core {
    /// Bounding box in its frame.
    pub fn aabb(&self) -> Aabb {
        let half = match self {
            Self::Point => DVec3::ZERO,
            Self::LineSegment { half_length } => DVec3::new(0.0, 0.0, *half_length),
            Self::Box { half_extents } => *half_extents,
            Self::Cylinder { radius, half_length } => DVec3::new(*radius, *radius, *half_length),
            Self::Hull(hull) => return hull.aabb(),
            Self::Triangle(corners) => return Aabb::of_points(*corners),
        };
        Aabb { min: -half, max: half }
    }

    /// The radius of a ball in the core about the centre of its bounding box, m.
    fn inner_radius(&self) -> f64 {
        match self {
            Self::Point | Self::LineSegment { .. } | Self::Triangle(_) => 0.0,
            Self::Box { half_extents } => half_extents.min_element(),
            Self::Cylinder { radius, half_length } => radius.min(*half_length),
            Self::Hull(hull) => hull.inner_radius(),
        }
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Point => DVec3::ZERO,
            Self::LineSegment { half_length } => {
                DVec3::new(0.0, 0.0, half_length.copysign(direction.z))
            }
            Self::Box { half_extents } => half_extents.copysign(direction),
            Self::Cylinder { radius, half_length } => {
                let rim = DVec3::new(direction.x, direction.y, 0.0).normalize_or_zero() * *radius;
                DVec3::new(rim.x, rim.y, half_length.copysign(direction.z))
            }
            Self::Hull(hull) => hull.support(direction),
            Self::Triangle(corners) => {
                let [a, b, c] = corners.map(|corner| corner.dot(direction));
                corners[if a >= b && a >= c {
                    0
                } else if b >= c {
                    1
                } else {
                    2
                }]
            }
        }
    }
}
