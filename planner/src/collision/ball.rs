//! Balls around the robot's links: what tells in no time that two things are apart.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::Shape;
use surefoot_shared_types::robot::{Link, RobotModel};

use super::bvh::Aabb;
use crate::kinematics::Tree;

/// Links with collision shapes, at most.
pub const BODIES_MAX: usize = 128;

/// A ball fixed to a frame.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre in that frame.
    pub center: DVec3,
    /// Its radius, m.
    pub radius: f64,
}

/// The ball around a link's collision shapes.
#[derive(Debug, Clone, Copy)]
pub struct BodyBall {
    /// The link.
    pub link: usize,
    /// The node that carries it.
    pub node: usize,
    /// The ball in the node's frame.
    pub ball: Ball,
}

/// The balls around all links with collision shapes; first those of held nodes, in link order.
pub fn body_balls(model: &RobotModel, tree: &Tree) -> Vec<BodyBall> {
    let with_shapes = model.links.iter().enumerate().filter(|(_, link)| !link.shapes.is_empty());
    let mut balls: Vec<BodyBall> = with_shapes
        .map(|(index, link)| {
            let (node, node_from_link) = tree.of_link(index);
            let Ball { center, radius } = ball_around(link);
            BodyBall { link: index, node, ball: Ball { center: node_from_link * center, radius } }
        })
        .collect();
    balls.sort_by_key(|body| body.node >= tree.held_len());
    balls
}

/// The ball around one shape, in its frame: about the middle of its box.
pub fn shape_ball(shape: &Shape) -> Ball {
    let center = bounds(shape).center();
    Ball { center, radius: radius_about(shape, center) }
}

/// A ball around all of a link's shapes.
fn ball_around(link: &Link) -> Ball {
    let balls = || link.shapes.iter().map(|placed| (placed, shape_ball(&placed.shape)));
    let boxes = balls().map(|(placed, ball)| {
        let center = placed.link_from_shape * ball.center;
        Aabb { min: center, max: center }.grown(ball.radius)
    });
    let center = boxes.fold(Aabb::EMPTY, Aabb::union).center();
    let reach = balls().map(|(placed, ball)| {
        let around = (placed.link_from_shape * ball.center - center).length() + ball.radius;
        radius_about(&placed.shape, placed.link_from_shape.inverse() * center).min(around)
    });
    Ball { center, radius: reach.fold(0.0, f64::max) }
}

/// The box around a shape, in its frame.
fn bounds(shape: &Shape) -> Aabb {
    let half = match shape {
        Shape::Box { half_extents } => *half_extents,
        Shape::Sphere { radius } => DVec3::splat(*radius),
        Shape::Cylinder { radius, half_length } => DVec3::new(*radius, *radius, *half_length),
        Shape::Capsule { radius, half_length } => {
            DVec3::new(*radius, *radius, half_length + radius)
        }
        Shape::ConvexHull { points } | Shape::Mesh { vertices: points, .. } => {
            return Aabb::of_points(points.iter().copied());
        }
    };
    Aabb { min: -half, max: half }
}

/// The radius of the ball around `center` (in the shape's frame) that holds the shape.
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
        Shape::ConvexHull { points } | Shape::Mesh { vertices: points, .. } => {
            points.iter().map(|point| (*point - center).length()).fold(0.0, f64::max)
        }
    }
}

/// How many middles are compared at once.
pub const LANES: usize = 4;

/// The middles of all bodies' balls in the root's frame, in three lists for the sake of loops over
/// them.
#[derive(Debug, Clone)]
pub struct Centers {
    x: [f64; BODIES_MAX],
    y: [f64; BODIES_MAX],
    z: [f64; BODIES_MAX],
    len: usize,
    held_len: usize,
}

impl Default for Centers {
    fn default() -> Self {
        Self {
            x: [0.0; BODIES_MAX],
            y: [0.0; BODIES_MAX],
            z: [0.0; BODIES_MAX],
            len: 0,
            held_len: 0,
        }
    }
}

impl Centers {
    /// Places the balls of held nodes, and forgets the others.
    pub fn place_held(
        &mut self,
        balls: &[BodyBall],
        held_nodes: usize,
        root_from_nodes: &[DAffine3],
    ) {
        self.len = 0;
        self.push(balls.iter().take_while(|body| body.node < held_nodes), root_from_nodes);
        self.held_len = self.len;
    }

    /// Places the balls of all other nodes.
    pub fn place_moving(
        &mut self,
        balls: &[BodyBall],
        held_nodes: usize,
        root_from_nodes: &[DAffine3],
    ) {
        self.len = self.held_len;
        self.push(balls.iter().skip_while(|body| body.node < held_nodes), root_from_nodes);
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.len
    }

    /// One of the middles.
    pub fn get(&self, body: usize) -> DVec3 {
        DVec3::new(self.x[body], self.y[body], self.z[body])
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.len).map(|body| self.get(body))
    }

    /// Whether all of them are numbers.
    pub fn are_finite(&self) -> bool {
        self.iter().sum::<DVec3>().is_finite()
    }

    /// Whether a point is further from all middles of a block of [`LANES`] than `reaches` says
    /// (m2); all must be numbers. It takes no branches, so that several are compared at once.
    #[inline]
    pub fn are_apart(&self, point: DVec3, block: usize, reaches: &[f64; LANES]) -> bool {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|list| &list.as_chunks::<LANES>().0[block]);
        let signs: [u64; LANES] = std::array::from_fn(|lane| {
            let (x, y, z) = (x[lane] - point.x, y[lane] - point.y, z[lane] - point.z);
            (reaches[lane] - (x * x + y * y + z * z)).to_bits()
        });
        ((signs[0] & signs[1]) & (signs[2] & signs[3])) >> 63 == 1
    }

    fn push<'a>(
        &mut self,
        balls: impl Iterator<Item = &'a BodyBall>,
        root_from_nodes: &[DAffine3],
    ) {
        // Robots with more bodies than fit are refused.
        for body in balls.take(BODIES_MAX - self.len) {
            let center = root_from_nodes[body.node].transform_point3(body.ball.center);
            (self.x[self.len], self.y[self.len], self.z[self.len]) = (center.x, center.y, center.z);
            self.len += 1;
        }
    }
}
