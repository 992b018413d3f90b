//! The soles on which the robot stands.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::{Foot, RobotModel};
use surefoot_shared_types::{Pose, Shape};

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::{distance_to, simplify};
use crate::geometry::resting_foot::{GroundPoint, clip_to_held};
use crate::robot::ankle_limits::AnkleLimits;

/// A sole: the flat bottom of a foot.
#[derive(Debug, Clone)]
pub struct Sole {
    /// Index of the foot's link.
    pub link: usize,
    /// Pose of the sole frame in the foot link's frame.
    pub link_from_sole: Pose,
    /// Outline in the sole frame (m), counter-clockwise: the declared one, without corners that do
    /// not touch level ground.
    pub polygon: Vec<DVec2>,
    /// Largest distance of a corner of the declared outline from the outline, m.
    pub retreat: f64,
    /// Limits of the centre of pressure from the ankle's torques.
    pub ankle_limits: AnkleLimits,
}

impl Sole {
    /// The sole of a foot. `centre_height` is the height of the centre of mass over it, m.
    pub(crate) fn new(
        model: &RobotModel,
        foot: &Foot,
        ankle_limits: AnkleLimits,
        centre_height: f64,
    ) -> Self {
        let polygon = touching_polygon(model, foot, centre_height);
        let retreat = |corner: &DVec2| distance_to(&polygon, *corner);
        Self {
            link: foot.link,
            link_from_sole: foot.link_from_sole,
            retreat: foot.polygon.iter().map(retreat).fold(0.0, f64::max),
            polygon,
            ankle_limits,
        }
    }

    /// The region (world x and y, m) in which the ankle can hold the robot's weight when the whole
    /// sole is supported.
    pub fn ankle_support_region(&self, world_from_sole: &Pose) -> ConvexRegion {
        ConvexRegion::seen_from_above(world_from_sole, &self.ankle_limits.clip(&self.polygon))
    }
}

/// Height over a foot's lowest point up to which its points may touch level ground, m.
const UNEVENNESS_MAX: f64 = 3e-3;
/// Sides of the polygon in place of a round foot.
const ROUND_SIDES: usize = 32;

/// The declared outline of a foot, less the part that its own shapes hold only by tilting: meshes of
/// feet are seldom flat to their rim. Where nothing is left, the declared outline.
fn touching_polygon(model: &RobotModel, foot: &Foot, centre_height: f64) -> Vec<DVec2> {
    let sole_from_link = foot.link_from_sole.inverse();
    let points: Vec<DVec3> = model.links[foot.link]
        .shapes
        .iter()
        .flat_map(|shape| {
            let sole_from_shape = sole_from_link * shape.link_from_shape;
            lowest_points(&shape.shape, &sole_from_shape)
        })
        .collect();
    let lowest = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    // Seen from the foot the ground is the higher, the lower the foot's underside is.
    let ground: Vec<GroundPoint> = points
        .iter()
        .filter(|point| point.z <= lowest + UNEVENNESS_MAX)
        .map(|point| GroundPoint { at: point.truncate().extend(-point.z), is_carrying: true })
        .collect();
    let mut polygon = foot.polygon.clone();
    clip_to_held(&mut polygon, &mut Vec::new(), &ground, centre_height);
    simplify(&mut polygon, POLYGON_VERTICES_MAX);
    if polygon.len() < 3 { foot.polygon.clone() } else { polygon }
}

/// The points of a shape that may be its lowest ones, in the sole frame, m.
fn lowest_points(shape: &Shape, sole_from_shape: &Pose) -> Vec<DVec3> {
    let corner = |half: DVec3, index: u32| {
        let sign = |axis: u32| if index >> axis & 1 == 1 { 1.0 } else { -1.0 };
        half * DVec3::new(sign(0), sign(1), sign(2))
    };
    let ring = |radius: f64, z: f64| {
        (0..ROUND_SIDES).map(move |k| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / ROUND_SIDES as f64);
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let below = |point: DVec3, radius: f64| *sole_from_shape * point - radius * DVec3::Z;
    let placed = |points: Vec<DVec3>| points.into_iter().map(|p| *sole_from_shape * p).collect();
    match shape {
        Shape::Box { half_extents } => placed((0..8).map(|i| corner(*half_extents, i)).collect()),
        Shape::Sphere { radius } => vec![below(DVec3::ZERO, *radius)],
        Shape::Capsule { radius, half_length } => {
            [-*half_length, *half_length].map(|z| below(z * DVec3::Z, *radius)).to_vec()
        }
        Shape::Cylinder { radius, half_length } => {
            placed(ring(*radius, -*half_length).chain(ring(*radius, *half_length)).collect())
        }
        Shape::ConvexHull { points } => placed(points.clone()),
        Shape::Mesh { vertices, .. } => placed(vertices.clone()),
    }
}
