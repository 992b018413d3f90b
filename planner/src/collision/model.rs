//! Collision of the robot with the world and with itself.
//!
//! Shapes are compiled once. Queries use f64, allocate no memory and may run on several threads at
//! once. A doubtful case counts as a hit: see [`narrow_phase`](crate::geometry::narrow_phase).

use std::collections::BTreeSet;

use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::collision::body_distance::bodies_within;
use crate::collision::error::CollisionError;
use crate::collision::keep_out::KeepOutZones;
use crate::collision::robot_bodies::{CollisionBody, FootBody, Part};
use crate::collision::self_pairs::{BodyPair, SelfPairs};
use crate::collision::tuning::{
    LIFT_OFF_LIFT, SLIDE_CLEAR_MIN, SLIDE_MAX, SLIDE_TURN_MAX, STANCE_LIFT,
};
use crate::collision::world_shapes::{Nearby, WorldShapes, lifted};
use crate::geometry::bvh::Aabb;
use crate::kinematics::tree::KinematicTree;
use crate::robot::bounding_spheres::{BODIES_MAX, BoundingSphere};
use crate::robot::kinematic_state::KinematicState;

/// The phase of a foot, which decides the clearance that it must keep.
///
/// Later phases keep more.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum FootPhase {
    /// Stands on the world: its sole may touch the ground.
    Stance,
    /// Moves along the sole normal just after lift-off or before landing: keeps clearance to the
    /// sides and above, none below the sole.
    LiftOff,
    /// As in lift-off, but farther from its foothold than a foot that touches the world may slide:
    /// its sole is clear of the world.
    Rising,
    /// Swings: keeps full clearance.
    Swing,
}

impl FootPhase {
    /// The phase of a swing foot that leaves one of its footholds or comes to it. `footholds` and
    /// `sole` are poses in one frame.
    pub fn of_leaving(footholds: &[Pose], sole: &Pose) -> Self {
        let may_touch = |foothold: &Pose| {
            sole.translation.distance(foothold.translation) <= SLIDE_MAX
                && rotation_distance(sole.rotation, foothold.rotation) <= SLIDE_TURN_MAX
        };
        if footholds.iter().any(may_touch) { Self::LiftOff } else { Self::Rising }
    }
}

/// Two shapes that are too near to each other.
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
        /// The other link.
        b: usize,
    },
}

/// Result of [`CollisionModel::foot_hit`] in a keep-out zone. Not the index of a shape.
pub const KEEP_OUT: usize = usize::MAX;

/// A robot in a world, compiled for collision checks.
#[derive(Debug, Clone)]
pub struct CollisionModel {
    bodies: Vec<CollisionBody>,
    pairs: SelfPairs,
    world: WorldShapes,
    clearance: f64,
    keep_out_zones: KeepOutZones,
    link_names: Vec<String>,
    shape_names: Vec<String>,
}

impl CollisionModel {
    /// Compiles a robot in a world. All shapes keep `clearance` (m, finite, at least 0) from each
    /// other.
    ///
    /// # Errors
    /// The first shape or number that cannot be used.
    pub fn new(model: &RobotModel, world: &World, clearance: f64) -> Result<Self, CollisionError> {
        if !(clearance.is_finite() && clearance >= 0.0) {
            return Err(CollisionError::BadClearance);
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
            keep_out_zones: KeepOutZones::default(),
            link_names,
            shape_names,
        })
    }

    /// A hit as a message with the names of its shapes.
    pub fn describe(&self, hit: Hit) -> String {
        match hit {
            Hit::World { link, shape } => format!(
                "link '{}' collides with '{}' of the world",
                self.link_names[link], self.shape_names[shape]
            ),
            Hit::SelfPair { a, b } => {
                format!("link '{}' collides with link '{}'", self.link_names[a], self.link_names[b])
            }
        }
    }

    /// The first hit of the robot with the world, which is cheaper, or with itself; `None` if all
    /// shapes keep their clearance. `feet` holds the phase of each foot.
    pub fn hit(&self, kinematic_state: &KinematicState, feet: &[FootPhase]) -> Option<Hit> {
        self.world_hit(kinematic_state, feet).or_else(|| self.self_hit(kinematic_state))
    }

    /// The first hit of the robot with the world. `feet` holds the phase of each foot.
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

    /// Index of the first world shape that one of the selected links hits; `is_selected` has one
    /// flag per link. The links' poses are given in the root frame.
    pub fn links_hit(
        &self,
        world_from_root: &Pose,
        root_from_links: &[Pose],
        is_selected: &[bool],
    ) -> Option<usize> {
        let bodies = self.bodies.iter().filter(|body| is_selected[body.link]);
        bodies.map(|body| (body, *world_from_root * root_from_links[body.node_link])).find_map(
            |(body, pose)| self.world.hit(body, &pose, self.clearance, &Nearby::INCOMPLETE),
        )
    }

    /// Bounding box of all shapes of the world.
    pub fn world_bounds(&self) -> Aabb {
        self.world.bounds()
    }

    /// The first hit of the robot with itself.
    pub fn self_hit(&self, kinematic_state: &KinematicState) -> Option<Hit> {
        let pair = self
            .pairs
            .find_near(kinematic_state.centers(), |pair| self.is_self_hit(pair, kinematic_state))?;
        let [a, b] = self.links_of(pair);
        Some(Hit::SelfPair { a, b })
    }

    /// All pairs of links that do not keep their clearance from each other, the smaller index
    /// first. Allocates memory: not for searches.
    pub fn self_hits(&self, kinematic_state: &KinematicState) -> BTreeSet<[usize; 2]> {
        let mut found = BTreeSet::new();
        self.pairs.find_near(kinematic_state.centers(), |pair| {
            if self.is_self_hit(pair, kinematic_state) {
                found.insert(self.links_of(pair));
            }
            false
        });
        found
    }

    fn is_self_hit(&self, pair: &BodyPair, kinematic_state: &KinematicState) -> bool {
        let frames = kinematic_state.root_from_nodes();
        let placed = |index: u32| {
            let body = &self.bodies[index as usize];
            (body, &frames[body.node])
        };
        pair.is_hit(placed(pair.a), placed(pair.b))
    }

    /// The links of two bodies, the smaller index first.
    fn links_of(&self, pair: &BodyPair) -> [usize; 2] {
        let [a, b] = [pair.a, pair.b].map(|index| self.bodies[index as usize].link);
        [a.min(b), a.max(b)]
    }

    /// Adds a keep-out zone where a sole had no contact: no sole may stand with its origin over
    /// that sole's rectangle, of half length and half width `half_sides` (m). Zones beyond
    /// `CORRECTIONS_MAX` are dropped.
    pub fn add_keep_out_zone(&mut self, world_from_sole: &Pose, half_sides: [f64; 2]) {
        self.keep_out_zones.add(world_from_sole, half_sides);
    }

    /// Index of the first world shape that a foot, with all links fixed to it, hits with its sole
    /// at a pose; [`KEEP_OUT`] in a keep-out zone.
    pub fn foot_hit(&self, limb: usize, world_from_sole: &Pose, phase: FootPhase) -> Option<usize> {
        if self.keep_out_zones.contain(world_from_sole.translation) {
            return Some(KEEP_OUT);
        }
        let world_from_node = |foot: &FootBody| *world_from_sole * foot.sole_from_node;
        self.foot_bodies(limb).find_map(|(body, foot)| {
            self.foot_body_hit(
                body,
                &world_from_node(&foot),
                foot.node_normal,
                phase,
                &Nearby::INCOMPLETE,
            )
        })
    }

    /// Index of the first world shape that overlaps a box, given by the pose of its centre and half
    /// of each side (m).
    pub fn box_hit(&self, world_from_box: &Pose, half_extents: DVec3) -> Option<usize> {
        self.world.box_hit(world_from_box, half_extents)
    }

    /// Index of the first world shape that a ball (centre and radius, m) touches.
    pub fn ball_hit(&self, center: DVec3, radius: f64) -> Option<usize> {
        self.world.ball_hit(center, radius)
    }

    /// A box around all points of a box in the world that may be farther than `reach` (m) from all
    /// shapes, and whether these are all of its points; `None` if there are none.
    pub fn free_part(&self, region: &Aabb, reach: f64) -> Option<(Aabb, bool)> {
        self.world.free_part(region, reach)
    }

    /// Calls `examine` with the bounding box of each shape of the world that overlaps a box.
    pub fn for_each_box(&self, around: &Aabb, examine: impl FnMut(&Aabb)) {
        self.world.for_each_box(around, examine);
    }

    /// A shape of the world within `reach` (m) of a point.
    pub fn shape_near(&self, point: DVec3, reach: f64) -> Option<usize> {
        self.world.shape_near(point, reach)
    }

    /// A lower bound of how far a point in a node's frame lies below the surface of the links that
    /// the node moves, m; minus infinity where no bound is known.
    pub fn depth_in_node(&self, node: usize, point: DVec3) -> f64 {
        let bodies = self.bodies.iter().filter(|body| body.node == node);
        let depth = |part: &Part| part.solid.depth(part.part_from_node.transform_point3(point));
        bodies.flat_map(|body| &body.parts).map(depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The boxes among the shapes of the links that a node moves: pose in the node's frame, and
    /// half of each side, m.
    pub fn boxes_in_node(&self, node: usize) -> impl Iterator<Item = (Pose, DVec3)> + '_ {
        let parts =
            self.bodies.iter().filter(move |body| body.node == node).flat_map(|body| &body.parts);
        parts.filter_map(|part| Some((part.node_from_part, part.solid.box_half_extents()?)))
    }

    /// A large ball, in the root frame, that a link rigid with the root contains.
    pub fn root_ball(&self) -> Option<BoundingSphere> {
        let rigid = self.bodies.iter().filter(|body| body.node == 0);
        let balls = rigid.flat_map(|body| &body.parts).map(|part| BoundingSphere {
            center: part.node_from_part * part.bounds.center(),
            radius: part.solid.inner_radius(),
        });
        balls.filter(|ball| ball.radius > 0.0).max_by(|a, b| a.radius.total_cmp(&b.radius))
    }

    /// The name of a shape of the world; none for [`KEEP_OUT`].
    pub fn shape_name(&self, shape: usize) -> Option<&str> {
        self.shape_names.get(shape).map(String::as_str)
    }

    /// Bounding box of a foot with all links fixed to it, in its sole's frame.
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

    /// The bounding box of every collision shape: the indices of its link and of the shape in the
    /// link, the shape's pose in the link's frame, and the box in the shape's frame. Upper-body
    /// links come first.
    pub fn part_bounds(&self) -> impl Iterator<Item = ([usize; 2], Pose, Aabb)> + '_ {
        self.bodies.iter().flat_map(|body| {
            let link_from_node = body.node_from_link.inverse();
            let parts = body.parts.iter().enumerate();
            parts.map(move |(index, part)| {
                ([body.link, index], link_from_node * part.node_from_part, part.bounds)
            })
        })
    }

    /// The foot that a link is, or is fixed to.
    pub fn foot_of(&self, link: usize) -> Option<usize> {
        self.bodies.iter().find(|body| body.link == link)?.foot.map(|foot| foot.limb)
    }

    /// Index of the first world shape that the root, with all links fixed to it, overlaps: the
    /// least space that the robot takes [Grey 4.1.1].
    pub fn root_hit(&self, world_from_root: &Pose) -> Option<usize> {
        let mut rigid = self.bodies.iter().filter(|body| body.node == 0);
        rigid.find_map(|body| self.world.hit(body, world_from_root, 0.0, &Nearby::INCOMPLETE))
    }

    /// Whether both feet, with all links fixed to them, are too near to each other at these sole
    /// poses.
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

    /// Upper bound (m) of the displacement of any point of any collision shape between two
    /// kinematic states.
    pub fn motion_bound(&self, a: &KinematicState, b: &KinematicState) -> f64 {
        // All quantities are in the root frame of `a`. A node that does not rotate in the root
        // frame rotates with the root.
        let (ra, rb) = (a.world_rotation(), b.world_rotation());
        let rotation = ra.transpose() * *rb;
        let shift = a.turned_to_root(b.world_from_root.translation - a.world_from_root.translation);
        let root_chord = chord_squared(&rotation, &DMat3::IDENTITY);
        let (frames_a, frames_b) = (a.root_from_nodes(), b.root_from_nodes());
        let mut bound: f64 = 0.0;
        for (index, body) in self.bodies.iter().enumerate() {
            let (at_a, at_b) = (&frames_a[body.node].matrix3, &frames_b[body.node].matrix3);
            let chord =
                if at_a == at_b { root_chord } else { chord_squared(&(rotation * *at_b), at_a) };
            let translated = (rotation * b.centers().get(index) + shift - a.centers().get(index))
                .length_squared();
            let rotated = chord * body.sphere.radius * body.sphere.radius;
            // sqrt(2 (t + r)) >= sqrt(t) + sqrt(r), so most bodies need no square root.
            if 2.0 * (translated + rotated) > bound * bound {
                bound = bound.max(translated.sqrt() + rotated.sqrt());
            }
        }
        bound
    }

    /// The pairs of links that may touch, in ascending order.
    pub fn allowed_pairs(&self) -> &[(usize, usize)] {
        &self.pairs.allowed
    }

    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        let bodies = size_of_val(self.bodies.as_slice())
            + self.bodies.iter().map(CollisionBody::bytes).sum::<usize>();
        bodies + self.pairs.bytes() + self.world.bytes()
    }

    fn foot_bodies(&self, limb: usize) -> impl Iterator<Item = (&CollisionBody, FootBody)> {
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
            FootPhase::Rising => ((self.clearance - SLIDE_CLEAR_MIN).max(0.0), self.clearance),
            FootPhase::Swing => (0.0, self.clearance),
        };
        self.world.hit(body, &lifted(world_from_node, node_normal, lift), margin, nearby)
    }
}

/// Squared displacement of a point at distance 1 by the rotation from one orientation to another,
/// at most: the squared chord of the rotation's angle.
fn chord_squared(a: &DMat3, b: &DMat3) -> f64 {
    let difference = *a - *b;
    0.5 * (difference.x_axis.length_squared()
        + difference.y_axis.length_squared()
        + difference.z_axis.length_squared())
}
