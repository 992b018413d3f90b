//! The outermost points of shapes.

use glam::DVec3;

use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;

/// Corners of the polygon that stands for a cylinder's rim.
const RIM_CORNERS: usize = 24;

/// Points of a surface, and balls of which every surface point counts.
#[derive(Debug, Clone, Default)]
pub(crate) struct SurfacePoints {
    pub(crate) points: Vec<DVec3>,
    /// Centres and radii, m.
    pub(crate) balls: Vec<(DVec3, f64)>,
}

impl SurfacePoints {
    /// Adds a shape.
    pub(crate) fn add(&mut self, shape: &Shape, from_shape: &Pose) {
        match shape {
            Shape::Box { half_extents } => {
                let corner = |bits: usize| {
                    DVec3::from_array([0, 1, 2].map(|axis| {
                        let sign = if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
                        sign * half_extents[axis]
                    }))
                };
                self.points.extend((0..8).map(|bits| *from_shape * corner(bits)));
            }
            Shape::Sphere { radius } => self.balls.push((from_shape.translation, *radius)),
            Shape::Capsule { radius, half_length } => {
                let end = |z: f64| (*from_shape * DVec3::new(0.0, 0.0, z), *radius);
                self.balls.extend([end(*half_length), end(-*half_length)]);
            }
            Shape::Cylinder { radius, half_length } => {
                for corner in 0..RIM_CORNERS {
                    let angle = std::f64::consts::TAU * corner as f64 / RIM_CORNERS as f64;
                    let (sin, cos) = libm::sincos(angle);
                    for z in [-half_length, *half_length] {
                        self.points.push(*from_shape * DVec3::new(radius * cos, radius * sin, z));
                    }
                }
            }
            Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
                self.points.extend(points.iter().map(|point| *from_shape * *point));
            }
        }
    }

    /// Whether no shape was added.
    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.balls.is_empty()
    }

    /// The farthest extent along a unit direction, m.
    pub(crate) fn extent(&self, direction: DVec3) -> f64 {
        let points = self.points.iter().map(|point| point.dot(direction));
        let balls = self.balls.iter().map(|(centre, radius)| centre.dot(direction) + radius);
        points.chain(balls).fold(f64::NEG_INFINITY, f64::max)
    }
}
