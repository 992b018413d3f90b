//! The robot's links as bodies: solids with the balls around them, and which of them stand on the ground.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::{Link, RobotModel};

use super::bvh::Aabb;
use super::error::CollisionError;
use super::kernels::Segment;
use super::solid::Solid;
use crate::kinematics::forward::Kinematics;

/// Links with collision shapes, at most.
pub const BODIES_MAX: usize = 128;

/// A ball fixed to a link.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre in the link frame.
    pub center: DVec3,
    /// Its radius, m.
    pub radius: f64,
}

/// One collision shape of a link.
#[derive(Debug, Clone)]
pub struct Part {
    /// The solid's frame in the link's.
    pub link_from_part: Pose,
    /// The solid.
    pub solid: Solid,
    /// The box around the solid in its own frame.
    pub bounds: Aabb,
    /// A ball around it.
    pub ball: Ball,
    /// The core in the link frame where it is a point or a segment; the solid is all within `solid`'s radius of it.
    pub spine: Option<Segment>,
}

/// A link with at least one collision shape.
#[derive(Debug, Clone)]
pub struct Body {
    /// The link.
    pub link: usize,
    /// Its shapes.
    pub parts: Vec<Part>,
    /// A ball around them all.
    pub ball: Ball,
    /// The foot that it is, or is rigidly joined to.
    pub foot: Option<FootBody>,
    /// The link's pose in the root's frame where no moving joint lies between them.
    pub root_from_link: Option<Pose>,
}

/// The middles of all bodies' balls in the world, in three lists for the sake of loops over them.
#[derive(Debug)]
pub struct Centers {
    /// World x, m.
    pub x: heapless::Vec<f64, BODIES_MAX>,
    /// World y, m.
    pub y: heapless::Vec<f64, BODIES_MAX>,
    /// World z, m.
    pub z: heapless::Vec<f64, BODIES_MAX>,
}

impl Centers {
    /// Where they are with the links at these poses.
    pub fn new(bodies: &[Body], world_from_links: &[Pose]) -> Self {
        let mut centers = Self { x: heapless::Vec::new(), y: heapless::Vec::new(), z: heapless::Vec::new() };
        for body in bodies {
            let center = world_from_links[body.link] * body.ball.center;
            // There are never more than fit: the model was built for no more.
            let _ = (centers.x.push(center.x), centers.y.push(center.y), centers.z.push(center.z));
        }
        centers
    }

    /// The box around all balls.
    pub fn around(&self, bodies: &[Body]) -> Aabb {
        let mut around = Aabb::EMPTY;
        for (((x, y), z), body) in self.x.iter().zip(&self.y).zip(&self.z).zip(bodies) {
            let center = DVec3::new(*x, *y, *z);
            around = around.union(Aabb { min: center, max: center }.grown(body.ball.radius));
        }
        around
    }
}

/// What a body knows of the foot that it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct FootBody {
    /// Index into `RobotModel::feet`.
    pub limb: usize,
    /// This body's link frame in the sole frame.
    pub sole_from_link: Pose,
    /// The sole's normal, out of the ground, in this body's link frame.
    pub link_normal: DVec3,
}

impl Body {
    /// All bodies of a robot, in link order.
    pub fn all(model: &RobotModel) -> Result<Vec<Self>, CollisionError> {
        let mut at_rest = vec![Pose::IDENTITY; model.links.len()];
        Kinematics::new(model).forward(&Pose::IDENTITY, &model.standing_q, &mut at_rest);
        let with_shapes = model.links.iter().enumerate().filter(|(_, link)| !link.shapes.is_empty());
        let bodies = with_shapes.map(|(index, link)| {
            let parts = Part::all(link)?;
            let ball = ball_around(&parts);
            let root_from_link = model.chain(index).is_empty().then_some(at_rest[index]);
            Ok(Self { link: index, parts, ball, foot: foot_of(model, index, &at_rest), root_from_link })
        });
        let bodies: Vec<Self> = bodies.collect::<Result<_, CollisionError>>()?;
        if bodies.len() > BODIES_MAX {
            return Err(CollisionError::TooManyBodies { count: bodies.len(), max: BODIES_MAX });
        }
        Ok(bodies)
    }

    /// Heap bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.parts.as_slice()) + self.parts.iter().map(|part| part.solid.bytes()).sum::<usize>()
    }
}

impl Part {
    fn all(link: &Link) -> Result<Vec<Self>, CollisionError> {
        let parts = link.shapes.iter().enumerate().map(|(index, placed)| {
            let owner = format!("link '{}', shape {index}", link.name);
            if !placed.link_from_shape.is_finite() {
                return Err(CollisionError::BadNumber { owner, what: "the pose", requirement: "finite" });
            }
            let solid = Solid::new(&placed.shape, &owner)?;
            let bounds = solid.aabb();
            let radius = solid.radius_about(bounds.center());
            let ball = Ball { center: placed.link_from_shape * bounds.center(), radius };
            let spine = solid.spine(&placed.link_from_shape);
            Ok(Self { link_from_part: placed.link_from_shape, solid, bounds, ball, spine })
        });
        parts.collect()
    }
}

/// A ball around the balls of some parts; one part's own ball where there is one part.
fn ball_around(parts: &[Part]) -> Ball {
    let boxes = parts.iter().map(|part| Aabb { min: part.ball.center, max: part.ball.center }.grown(part.ball.radius));
    let center = boxes.fold(Aabb::EMPTY, Aabb::union).center();
    let reach = |part: &Part| {
        let solid_center = part.link_from_part.inverse() * center;
        part.solid.radius_about(solid_center).min((part.ball.center - center).length() + part.ball.radius)
    };
    Ball { center, radius: parts.iter().map(reach).fold(0.0, f64::max) }
}

fn foot_of(model: &RobotModel, link: usize, at_rest: &[Pose]) -> Option<FootBody> {
    let limb = model.feet.iter().position(|foot| joints_between(model, foot.link, link) == 0)?;
    let foot = &model.feet[limb];
    let link_from_sole = at_rest[link].inverse() * at_rest[foot.link] * foot.link_from_sole;
    Some(FootBody { limb, sole_from_link: link_from_sole.inverse(), link_normal: link_from_sole.rotation * DVec3::Z })
}

/// How many moving joints lie on the way from one link to another.
pub fn joints_between(model: &RobotModel, a: usize, b: usize) -> usize {
    let (chain_a, chain_b) = (model.chain(a), model.chain(b));
    let shared = chain_a.iter().zip(&chain_b).take_while(|(a, b)| a == b).count();
    chain_a.len() + chain_b.len() - 2 * shared
}
