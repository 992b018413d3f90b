//! Collision of the robot with the world and with itself.
//!
//! Everything is prepared once; queries are exact (f64), allocate nothing and may run on any number
//! of threads at once. In doubt the answer is a hit: see [`narrow`].

use crate::collision::robot_bodies;
use glam::{DMat3, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::collision::robot_bodies::CollisionBody;
use crate::collision::self_pairs::{BodyPair, SelfPairs, bodies_within};
use crate::collision::world_shapes::{Nearby, WorldShapes, lifted};
use crate::geometry::bvh::Aabb;
use crate::geometry::shape_error::CollisionError;
use crate::robot::bounding_spheres::BODIES_MAX;

use crate::kinematics::KinematicTree;
use crate::robot::kinematic_state::KinematicState;

/// What a foot does, which decides how near it may come to the world.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FootPhase {
    /// Stands on the world: its sole may touch what it stands on.
    Stance,
    /// Lifting off or landing along its sole normal: clearance to the sides and above, none asked
    /// below the sole.
    LiftOff,
    /// In the air: full clearance.
    Swing,
}

/// What is too near to what.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Hit {
    /// A link and a shape of the world.
    World {
        /// Index into `RobotModel::links`.
        link: usize,
        /// Index into `World::shapes`.
        shape: usize,
    },
    /// Two links.
    SelfPair {
        /// The link with the smaller index.
        a: usize,
        /// The other one.
        b: usize,
    },
}

/// A standing foot is lifted by this much (m) before it is tested: the sole may touch, but not sink
/// in any further.
const STANCE_LIFT: f64 = 0.0015;
/// A foot that lifts off is lifted by this much (m) more than its clearance.
const LIFT_OFF_LIFT: f64 = 0.0005;

/// A robot in a world, prepared for collision checks.
#[derive(Debug, Clone)]
pub struct CollisionModel {
    bodies: Vec<CollisionBody>,
    pairs: SelfPairs,
    world: WorldShapes,
    clearance: f64,
    keep_out_zones: heapless::Vec<KeepOutZone, CORRECTIONS_MAX>,
    link_names: Vec<String>,
    shape_names: Vec<String>,
}

/// A place where nothing carries a sole, whatever the shapes say.
#[derive(Debug, Clone, Copy)]
struct KeepOutZone {
    sole_from_world: Pose,
    half_sides: DVec2,
}

/// What [`CollisionModel::foot_hit`] answers where a sole is known not to be carried: no shape's
/// index.
pub const KEEP_OUT: usize = usize::MAX;
/// How far above or below a keep-out place a sole still counts as standing there, m.
const KEEP_OUT_HEIGHT: f64 = 0.05;

impl CollisionModel {
    /// Prepares a robot in a world; everything shall keep `clearance` (m, finite, at least 0) from
    /// everything.
    ///
    /// # Errors
    /// Names the first shape or number that cannot be used.
    pub fn new(model: &RobotModel, world: &World, clearance: f64) -> Result<Self, CollisionError> {
        if !(clearance.is_finite() && clearance >= 0.0) {
            return Err(CollisionError::BadNumber {
                owner: "planner".into(),
                what: "clearance",
                requirement: "finite and not negative",
            });
        }
        let bodies = CollisionBody::all(model, &KinematicTree::new(model))?;
        let pairs = SelfPairs::new(model, &bodies, clearance);
        let link_names = model.links.iter().map(|link| link.name.clone()).collect();
        let shape_names = world.shapes.iter().map(|shape| shape.name.clone()).collect();
        let world = WorldShapes::new(world)?;
        Ok(Self {
            bodies,
            pairs,
            world,
            clearance,
            keep_out_zones: heapless::Vec::new(),
            link_names,
            shape_names,
        })
    }

    /// A hit in words, for a person.
    pub fn describe(&self, hit: Hit) -> String {
        match hit {
            Hit::World { link, shape } => format!(
                "link '{}' meets '{}' of the world",
                self.link_names[link], self.shape_names[shape]
            ),
            Hit::SelfPair { a, b } => {
                format!("link '{}' meets link '{}'", self.link_names[a], self.link_names[b])
            }
        }
    }

    /// The first hit with the world, which is cheaper to ask, or of the robot with itself; `None`
    /// where everything keeps its clearance, subject to what the `feet` (one state per foot) do.
    pub fn hit(&self, kinematic_state: &KinematicState, feet: &[FootPhase]) -> Option<Hit> {
        self.world_hit(kinematic_state, feet).or_else(|| self.self_hit(kinematic_state))
    }

    /// The first hit of the robot with the world.
    pub fn world_hit(&self, kinematic_state: &KinematicState, feet: &[FootPhase]) -> Option<Hit> {
        let centers = self.world_centers(kinematic_state);
        let mut around = Aabb::EMPTY;
        for (center, body) in centers.iter().zip(&self.bodies) {
            around = around.union(Aabb { min: *center, max: *center }.grown(body.sphere.radius));
        }
        let nearby =
            self.world.nearby(&around.grown(STANCE_LIFT.max(2.0 * self.clearance + LIFT_OFF_LIFT)));
        self.bodies.iter().zip(&centers).find_map(|(body, center)| {
            let shape = match body.foot {
                Some(foot) => self.foot_body_hit(
                    body,
                    &kinematic_state.world_from_node(body.node),
                    foot.node_normal,
                    feet[foot.limb],
                    &nearby,
                ),
                None if !self.world.reaches(
                    *center,
                    body.sphere.radius + self.clearance,
                    &nearby,
                ) =>
                {
                    None
                }
                None => self.world.hit(
                    body,
                    &kinematic_state.world_from_node(body.node),
                    self.clearance,
                    &nearby,
                ),
            };
            shape.map(|shape| Hit::World { link: body.link, shape })
        })
    }

    fn world_centers(&self, kinematic_state: &KinematicState) -> heapless::Vec<DVec3, BODIES_MAX> {
        kinematic_state.centers().iter().map(|center| kinematic_state.to_world(center)).collect()
    }

    /// The first world shape that the wanted links (one flag per link) hit, their poses given in
    /// the root's frame.
    pub fn carried_hit(
        &self,
        world_from_root: &Pose,
        root_from_links: &[Pose],
        wanted: &[bool],
    ) -> Option<usize> {
        let bodies = self.bodies.iter().filter(|body| wanted[body.link]);
        bodies
            .map(|body| (body, *world_from_root * root_from_links[body.node_link]))
            .find_map(|(body, pose)| self.world.hit(body, &pose, self.clearance, &Nearby::UNKNOWN))
    }

    /// The box around all shapes of the world.
    pub fn world_bounds(&self) -> Aabb {
        self.world.bounds()
    }

    /// The first hit of the robot with itself.
    pub fn self_hit(&self, kinematic_state: &KinematicState) -> Option<Hit> {
        let frames = kinematic_state.root_from_nodes();
        let placed = |index: u32| {
            let body = &self.bodies[index as usize];
            (body, &frames[body.node])
        };
        let is_hit = |pair: &BodyPair| pair.is_hit(placed(pair.a), placed(pair.b));
        let pair = self.pairs.find_near(kinematic_state.centers(), is_hit)?;
        let [a, b] = [pair.a, pair.b].map(|index| self.bodies[index as usize].link);
        Some(Hit::SelfPair { a: a.min(b), b: a.max(b) })
    }

    /// Keeps soles away from where one was not carried: none may be placed with its middle over
    /// that sole's rectangle, whose half length and half width are `half_sides` (m). Of more than
    /// [`CORRECTIONS_MAX`] places the last ones are not kept.
    pub fn add_keep_out_zone(&mut self, world_from_sole: &Pose, half_sides: [f64; 2]) {
        let _ = self.keep_out_zones.push(KeepOutZone {
            sole_from_world: world_from_sole.inverse(),
            half_sides: half_sides.into(),
        });
    }

    /// The first world shape that a foot alone, with what is rigidly joined to it, hits with its
    /// sole at a pose; or [`KEEP_OUT`].
    pub fn foot_hit(&self, limb: usize, world_from_sole: &Pose, phase: FootPhase) -> Option<usize> {
        if self.keep_out_zones.iter().any(|zone| zone.contains(world_from_sole.translation)) {
            return Some(KEEP_OUT);
        }
        let world_from_node =
            |foot: &robot_bodies::FootBody| *world_from_sole * foot.sole_from_node;
        self.foot_bodies(limb).find_map(|(body, foot)| {
            self.foot_body_hit(
                body,
                &world_from_node(&foot),
                foot.node_normal,
                phase,
                &Nearby::UNKNOWN,
            )
        })
    }

    /// The first world shape that meets a box, given by its middle's pose and half of each side
    /// (m).
    pub fn box_hit(&self, world_from_box: &Pose, half_extents: DVec3) -> Option<usize> {
        self.world.box_hit(world_from_box, half_extents)
    }

    /// The box around a foot and all that is rigidly joined to it, in its sole's frame.
    pub fn foot_bounds(&self, limb: usize) -> Aabb {
        let parts = self.foot_bodies(limb).flat_map(|(body, foot)| {
            body.parts.iter().map(move |part| (part, foot.sole_from_node))
        });
        let boxes = parts.map(|(part, sole_from_node)| {
            let sole_from_part = sole_from_node * part.node_from_part;
            part.bounds
                .transformed(&DMat3::from_quat(sole_from_part.rotation), sole_from_part.translation)
        });
        boxes.fold(Aabb::EMPTY, Aabb::union)
    }

    /// The bounding box of every collision shape: its link and which of the link's shapes it is,
    /// its frame in the link's, the box in its frame. Not in the order of the links.
    pub fn part_bounds(&self) -> impl Iterator<Item = ([usize; 2], Pose, Aabb)> + '_ {
        self.bodies.iter().flat_map(|body| {
            let link_from_node = body.node_from_link.inverse();
            let parts = body.parts.iter().enumerate();
            parts.map(move |(index, part)| {
                ([body.link, index], link_from_node * part.node_from_part, part.bounds)
            })
        })
    }

    /// The foot that a link is, or is rigidly joined to.
    pub fn foot_of(&self, link: usize) -> Option<usize> {
        self.bodies.iter().find(|body| body.link == link)?.foot.map(|foot| foot.limb)
    }

    /// The first world shape that what is rigid with the root meets, the least that the robot takes
    /// up [Grey 4.1.1].
    pub fn root_hit(&self, world_from_root: &Pose) -> Option<usize> {
        let mut rigid = self.bodies.iter().filter(|body| body.node == 0);
        rigid.find_map(|body| self.world.hit(body, world_from_root, 0.0, &Nearby::UNKNOWN))
    }

    /// Whether the first two feet, with what is rigidly joined to them, come too near to each other
    /// at these sole poses.
    pub fn feet_hit(&self, world_from_soles: [&Pose; 2]) -> bool {
        let limb_of = |body: u32| self.bodies[body as usize].foot.filter(|foot| foot.limb < 2);
        self.pairs.checked.iter().any(|pair| match (limb_of(pair.a), limb_of(pair.b)) {
            (Some(foot_a), Some(foot_b)) if foot_a.limb != foot_b.limb => {
                let world_from_a = *world_from_soles[foot_a.limb] * foot_a.sole_from_node;
                let world_from_b = *world_from_soles[foot_b.limb] * foot_b.sole_from_node;
                let (a, b) = (&self.bodies[pair.a as usize], &self.bodies[pair.b as usize]);
                bodies_within(a, &world_from_a, b, &world_from_b, pair.clearance)
            }
            _ => false,
        })
    }

    /// A bound (m) on how far any point of any collision shape lies from itself in two kinematic
    /// states.
    pub fn motion_bound(&self, a: &KinematicState, b: &KinematicState) -> f64 {
        // All is seen in the root's frame in `a`; what does not move in the root's frame turns as
        // the root does.
        let (ra, rb) = (a.world_rotation(), b.world_rotation());
        let turn = ra.transpose() * *rb;
        let shift = a.turned_to_root(b.world_from_root.translation - a.world_from_root.translation);
        let root_chord = chord_squared(&turn, &DMat3::IDENTITY);
        let (frames_a, frames_b) = (a.root_from_nodes(), b.root_from_nodes());
        let mut bound: f64 = 0.0;
        for (index, body) in self.bodies.iter().enumerate() {
            let (at_a, at_b) = (&frames_a[body.node].matrix3, &frames_b[body.node].matrix3);
            let chord =
                if at_a == at_b { root_chord } else { chord_squared(&(turn * *at_b), at_a) };
            let moved =
                (turn * b.centers().get(index) + shift - a.centers().get(index)).length_squared();
            let turned = chord * body.sphere.radius * body.sphere.radius;
            // The sum of two lengths is at most this root: most bodies need no other.
            if 2.0 * (moved + turned) > bound * bound {
                bound = bound.max(moved.sqrt() + turned.sqrt());
            }
        }
        bound
    }

    /// The pairs of links that may touch, in ascending order.
    pub fn allowed_pairs(&self) -> &[(usize, usize)] {
        &self.pairs.allowed
    }

    /// Heap bytes.
    pub fn bytes(&self) -> usize {
        let bodies = size_of_val(self.bodies.as_slice())
            + self.bodies.iter().map(CollisionBody::bytes).sum::<usize>();
        bodies + self.pairs.bytes() + self.world.bytes()
    }

    fn foot_bodies(
        &self,
        limb: usize,
    ) -> impl Iterator<Item = (&CollisionBody, robot_bodies::FootBody)> {
        self.bodies.iter().filter_map(move |body| {
            body.foot.filter(|foot| foot.limb == limb).map(|foot| (body, foot))
        })
    }

    fn foot_body_hit(
        &self,
        body: &CollisionBody,
        world_from_node: &Pose,
        node_normal: DVec3,
        phase: FootPhase,
        nearby: &Nearby,
    ) -> Option<usize> {
        let (lift, margin) = match phase {
            FootPhase::Stance => (STANCE_LIFT, 0.0),
            FootPhase::LiftOff => (self.clearance + LIFT_OFF_LIFT, self.clearance),
            FootPhase::Swing => (0.0, self.clearance),
        };
        self.world.hit(body, &lifted(world_from_node, node_normal, lift), margin, nearby)
    }
}

/// The squared distance (of a radius of 1) by which the turn from one rotation to another moves a
/// point at the most: the chord of its angle.
fn chord_squared(a: &DMat3, b: &DMat3) -> f64 {
    let apart = *a - *b;
    0.5 * (apart.x_axis.length_squared()
        + apart.y_axis.length_squared()
        + apart.z_axis.length_squared())
}

impl KeepOutZone {
    fn contains(&self, position: DVec3) -> bool {
        let at = self.sole_from_world * position;
        at.x.abs() <= self.half_sides.x
            && at.y.abs() <= self.half_sides.y
            && at.z.abs() <= KEEP_OUT_HEIGHT
    }
}
