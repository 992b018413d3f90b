//! The outermost points of shapes.

use glam::DVec3;

use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;

/// Corners of the polygon that stands for a cylinder's rim.
const RIM_CORNERS: usize = 24;

/// Least cosine between a cylinder's axis and a direction in which its flat end is the outermost
/// part, and not one point of its rim.
const END_COS_MIN: f64 = 0.9;

/// Points of a surface, and balls and rims of which every surface point counts.
#[derive(Debug, Clone, Default)]
pub(crate) struct SurfacePoints {
    pub(crate) points: Vec<DVec3>,
    /// Centres and radii, m.
    pub(crate) balls: Vec<(DVec3, f64)>,
    /// The rims of cylinders.
    pub(crate) rims: Vec<Rim>,
}

/// A circle.
#[derive(Debug, Clone)]
pub(crate) struct Rim {
    centre: DVec3,
    /// A unit vector across it.
    axis: DVec3,
    /// Points on it.
    corners: Vec<DVec3>,
    /// In metres.
    radius: f64,
}

impl Rim {
    fn new(from_shape: &Pose, z: f64, radius: f64) -> Self {
        let corner = |corner: usize| {
            let angle = std::f64::consts::TAU * corner as f64 / RIM_CORNERS as f64;
            let (sin, cos) = libm::sincos(angle);
            *from_shape * DVec3::new(radius * cos, radius * sin, z)
        };
        Self {
            centre: *from_shape * DVec3::new(0.0, 0.0, z),
            axis: from_shape.rotation * DVec3::Z,
            corners: (0..RIM_CORNERS).map(corner).collect(),
            radius,
        }
    }

    /// Its outermost point along a unit direction.
    fn outermost(&self, direction: DVec3) -> DVec3 {
        let outward = direction.reject_from_normalized(self.axis).normalize_or_zero();
        self.centre + self.radius * outward
    }
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
                let rim = |z: f64| Rim::new(from_shape, z, *radius);
                self.rims.extend([rim(-half_length), rim(*half_length)]);
            }
            Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
                self.points.extend(points.iter().map(|point| *from_shape * *point));
            }
        }
    }

    /// Whether no shape was added.
    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.balls.is_empty() && self.rims.is_empty()
    }

    /// The farthest extent along a unit direction, m.
    pub(crate) fn extent(&self, direction: DVec3) -> f64 {
        let points = self.points.iter().map(|point| point.dot(direction));
        let balls = self.balls.iter().map(|(centre, radius)| centre.dot(direction) + radius);
        let rims = self.rims.iter().map(|rim| rim.outermost(direction).dot(direction));
        points.chain(balls).chain(rims).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The points on which the surface may stand that faces along a unit direction: of a ball or a
    /// lying cylinder only the lowest ones, however near others are.
    pub(crate) fn standing_points(&self, direction: DVec3) -> impl Iterator<Item = DVec3> {
        let balls = self.balls.iter().map(move |(centre, radius)| *centre + *radius * direction);
        let of_rim = move |rim: &Rim| {
            let is_end = rim.axis.dot(direction).abs() >= END_COS_MIN;
            if is_end { rim.corners.clone() } else { vec![rim.outermost(direction)] }
        };
        self.points.iter().copied().chain(balls).chain(self.rims.iter().flat_map(of_rim))
    }

    /// Points of the surface in all directions.
    pub(crate) fn all_points(&self) -> impl Iterator<Item = DVec3> {
        let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
        let of_ball = move |(centre, radius): &(DVec3, f64)| {
            let (centre, radius) = (*centre, *radius);
            axes.clone().map(move |axis| centre + radius * axis)
        };
        let of_rims = self.rims.iter().flat_map(|rim| rim.corners.iter().copied());
        self.points.iter().copied().chain(self.balls.iter().flat_map(of_ball)).chain(of_rims)
    }
}
