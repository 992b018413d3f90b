//! Bounding spheres of the robot's links: a cheap first test of whether two bodies are apart.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::Shape;
use surefoot_shared_types::robot::model::{Link, RobotModel};

use crate::geometry::bvh::Aabb;
use crate::kinematics::tree::KinematicTree;

/// Most links with collision shapes.
pub const BODIES_MAX: usize = 128;

/// A sphere fixed to a frame.
#[derive(Debug, Clone, Copy)]
pub struct BoundingSphere {
    /// Its centre in that frame, m.
    pub center: DVec3,
    /// Its radius, m.
    pub radius: f64,
}

/// The sphere around a link's collision shapes.
#[derive(Debug, Clone, Copy)]
pub struct BodySphere {
    /// Index of the link.
    pub link: usize,
    /// The node that moves the link.
    pub node: usize,
    /// The sphere in the node's frame.
    pub sphere: BoundingSphere,
}

/// The spheres around all links with collision shapes: first those of upper-body nodes, each group
/// in link order.
pub fn body_spheres(model: &RobotModel, tree: &KinematicTree) -> Vec<BodySphere> {
    let with_shapes = model.links.iter().enumerate().filter(|(_, link)| !link.shapes.is_empty());
    let mut spheres: Vec<BodySphere> = with_shapes
        .map(|(index, link)| {
            let (node, node_from_link) = tree.of_link(index);
            let BoundingSphere { center, radius } = sphere_around(link);
            BodySphere {
                link: index,
                node,
                sphere: BoundingSphere { center: node_from_link * center, radius },
            }
        })
        .collect();
    spheres.sort_by_key(|body| body.node >= tree.upper_body_len());
    spheres
}

/// The sphere around a shape in its frame, about the centre of its bounding box.
pub fn shape_sphere(shape: &Shape) -> BoundingSphere {
    let center = bounds(shape).center();
    BoundingSphere { center, radius: radius_about(shape, center) }
}

/// A sphere around all shapes of a link, in the link's frame.
fn sphere_around(link: &Link) -> BoundingSphere {
    let spheres = || link.shapes.iter().map(|placed| (placed, shape_sphere(&placed.shape)));
    let boxes = spheres().map(|(placed, sphere)| {
        let center = placed.link_from_shape * sphere.center;
        Aabb { min: center, max: center }.grown(sphere.radius)
    });
    let center = boxes.fold(Aabb::EMPTY, Aabb::union).center();
    let reach = spheres().map(|(placed, sphere)| {
        let around = (placed.link_from_shape * sphere.center - center).length() + sphere.radius;
        radius_about(&placed.shape, placed.link_from_shape.inverse() * center).min(around)
    });
    BoundingSphere { center, radius: reach.fold(0.0, f64::max) }
}

/// The bounding box of a shape in its frame.
fn bounds(shape: &Shape) -> Aabb {
    let half = match shape {
        Shape::Box { half_extents } => *half_extents,
        Shape::Sphere { radius } => DVec3::splat(*radius),
        Shape::Cylinder { radius, half_length } => DVec3::new(*radius, *radius, *half_length),
        Shape::Capsule { radius, half_length } => {
            DVec3::new(*radius, *radius, half_length + radius)
        }
        Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
            return Aabb::of_points(points.iter().copied());
        }
    };
    Aabb { min: -half, max: half }
}

/// The radius (m) of the smallest sphere about `center` (in the shape's frame) that contains the
/// shape.
fn radius_about(shape: &Shape, center: DVec3) -> f64 {
    match shape {
        Shape::Box { half_extents } => (*half_extents + center.abs()).length(),
        Shape::Sphere { radius } => radius + center.length(),
        Shape::Capsule { radius, half_length } => {
            radius + (DVec3::Z * *half_length + center.abs()).length()
        }
        Shape::Cylinder { radius, half_length } => {
            let across = radius + center.truncate().length();
            DVec3::new(across, 0.0, half_length + center.z.abs()).length()
        }
        Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
            points.iter().map(|point| (*point - center).length()).fold(0.0, f64::max)
        }
    }
}

/// Number of centres that are compared at once (SIMD lanes).
pub const LANES: usize = 4;

/// The centres of all bodies' spheres in the root frame, as a structure of arrays: loops over them
/// vectorize.
#[derive(Debug, Clone)]
pub struct Centers {
    x: [f64; BODIES_MAX],
    y: [f64; BODIES_MAX],
    z: [f64; BODIES_MAX],
    len: usize,
    upper_body_len: usize,
}

impl Default for Centers {
    fn default() -> Self {
        Self {
            x: [0.0; BODIES_MAX],
            y: [0.0; BODIES_MAX],
            z: [0.0; BODIES_MAX],
            len: 0,
            upper_body_len: 0,
        }
    }
}

impl Centers {
    /// Places the spheres of upper-body nodes and removes all others.
    pub fn place_upper_body(
        &mut self,
        spheres: &[BodySphere],
        upper_body_len: usize,
        root_from_nodes: &[DAffine3],
    ) {
        self.len = 0;
        self.push(spheres.iter().take_while(|body| body.node < upper_body_len), root_from_nodes);
        self.upper_body_len = self.len;
    }

    /// Places the spheres of leg nodes behind those of upper-body nodes.
    pub fn place_legs(
        &mut self,
        spheres: &[BodySphere],
        upper_body_len: usize,
        root_from_nodes: &[DAffine3],
    ) {
        self.len = self.upper_body_len;
        self.push(spheres.iter().skip_while(|body| body.node < upper_body_len), root_from_nodes);
    }

    /// Number of centres.
    pub fn count(&self) -> usize {
        self.len
    }

    /// The centre of a body's sphere.
    pub fn get(&self, body: usize) -> DVec3 {
        DVec3::new(self.x[body], self.y[body], self.z[body])
    }

    /// All centres, in the order of the bodies.
    pub fn iter(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.len).map(|body| self.get(body))
    }

    /// Whether all coordinates are finite.
    pub fn are_finite(&self) -> bool {
        self.iter().sum::<DVec3>().is_finite()
    }

    /// Whether every centre of block `block` (of [`LANES`] centres) is farther from a point than
    /// the corresponding squared reach (m2). All numbers must be finite. Has no branches, so that
    /// the lanes are compared at once.
    #[inline]
    pub fn are_apart(&self, point: DVec3, block: usize, reaches_squared: &[f64; LANES]) -> bool {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|list| &list.as_chunks::<LANES>().0[block]);
        let signs: [u64; LANES] = std::array::from_fn(|lane| {
            let (x, y, z) = (x[lane] - point.x, y[lane] - point.y, z[lane] - point.z);
            (reaches_squared[lane] - (x * x + y * y + z * z)).to_bits()
        });
        ((signs[0] & signs[1]) & (signs[2] & signs[3])) >> 63 == 1
    }

    fn push<'a>(
        &mut self,
        spheres: impl Iterator<Item = &'a BodySphere>,
        root_from_nodes: &[DAffine3],
    ) {
        // The collision model rejects robots with more bodies.
        for body in spheres.take(BODIES_MAX - self.len) {
            let center = root_from_nodes[body.node].transform_point3(body.sphere.center);
            (self.x[self.len], self.y[self.len], self.z[self.len]) = (center.x, center.y, center.z);
            self.len += 1;
        }
    }
}
