//! Which pairs of links may touch, and how far apart the others have to stay.

use glam::DAffine3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{RobotModel, joints_between};

use crate::base::random::{Random, Stream};
use crate::collision::robot_bodies::{CollisionBody, Part};
use crate::collision::separating_direction::SeparatingDirection;
use crate::geometry::distance::{exceeds, segment_segment_distance_squared};
use crate::geometry::narrow_phase::{is_within, separating_direction};
use crate::kinematics::Kinematics;
use crate::kinematics::tree::{affine, pose};
use crate::robot::bounding_spheres::{Centers, LANES};

/// A pair of bodies that is checked.
#[derive(Debug, Clone, Copy)]
pub struct BodyPair {
    /// Index of the first body.
    pub a: u32,
    /// Index of the second body, the larger one.
    pub b: u32,
    /// The distance to keep, m.
    pub clearance: f64,
    /// Along which the two are apart as the robot stands, and mostly so elsewhere too; `None` where
    /// there is no distance, or where one is a sphere or a capsule or has several parts.
    standing_separation: Option<SeparatingDirection>,
}

impl BodyPair {
    /// Whether two bodies whose balls are known to be near come within the pair's clearance of each
    /// other; their nodes' frames are given in any common one.
    pub fn is_hit(&self, a: (&CollisionBody, &DAffine3), b: (&CollisionBody, &DAffine3)) -> bool {
        let are_apart = self.standing_separation.is_some_and(|direction| {
            direction.is_separated(a.1, (&b.0.parts[0], b.1), self.clearance)
        });
        !are_apart && parts_within(a, b, self.clearance)
    }
}

/// The pairs to check, and those to leave alone.
#[derive(Debug, Clone)]
pub struct SelfPairs {
    /// Pairs to check, in ascending order.
    pub checked: Vec<BodyPair>,
    /// Links of pairs that may touch, in ascending order.
    pub allowed: Vec<(usize, usize)>,
    /// Numbers in a row of the tables.
    stride: usize,
    /// For each two bodies, row by row: up to which squared distance of their balls' centres (m2)
    /// the solids have to be looked at; less than 0 for those that may touch, for pairs the other
    /// way around, and at each row's end.
    reach_squared: Vec<f64>,
    /// For each two bodies the pair that they are, as an index.
    places: Vec<u32>,
}

/// Random configurations that tell which pairs always collide.
const SAMPLES: usize = 300;
/// Pairs that collide in at least this many of them (95 %) may touch.
const ALWAYS: usize = SAMPLES * 95 / 100;
/// Pairs that collide at position zero may touch where at most this many moving joints lie between
/// them.
const NEIGHBOR_JOINTS_MAX: usize = 3;
/// Halvings in the search of the clearance at rest: below a nanometre of any clearance in use.
const HALVINGS: usize = 30;

impl SelfPairs {
    /// Sorts the pairs of a robot's bodies; `clearance` (m) is asked where the standing posture
    /// leaves room for it.
    pub fn new(model: &RobotModel, bodies: &[CollisionBody], clearance: f64) -> Self {
        let unlocked = model.unlocked();
        let survey = Survey::new(model, &unlocked, bodies);
        let mut allowed = Vec::new();
        let mut checked = Vec::new();
        let stride = bodies.len().next_multiple_of(LANES);
        let mut reach_squared = vec![-1.0; bodies.len() * stride];
        let mut places = vec![0; bodies.len() * stride];
        for (a, body_a) in bodies.iter().enumerate() {
            for (b, body_b) in bodies.iter().enumerate().skip(a + 1) {
                let links = [body_a.link, body_b.link];
                let joints = joints_between(&unlocked.links, links);
                let touches_at_zero =
                    || joints <= NEIGHBOR_JOINTS_MAX && touch(bodies, [a, b], &survey.zero);
                if joints <= 1 || survey.hits(bodies, [a, b]) >= ALWAYS || touches_at_zero() {
                    allowed.push((body_a.link.min(body_b.link), body_a.link.max(body_b.link)));
                    continue;
                }
                let is_one_piece = joints_between(&model.links, links) == 0;
                if is_one_piece && !survey.touches_standing(body_a, body_b) {
                    continue;
                }
                let clearance = clearance_at_rest(body_a, body_b, &survey.standing, clearance);
                let reach = body_a.sphere.radius + body_b.sphere.radius + clearance;
                reach_squared[a * stride + b] = reach * reach;
                places[a * stride + b] = checked.len() as u32;
                let standing_separation = standing_separation(body_a, body_b, &survey.standing);
                checked.push(BodyPair { a: a as u32, b: b as u32, clearance, standing_separation });
            }
        }
        allowed.sort_unstable();
        Self { checked, allowed, stride, reach_squared, places }
    }

    /// The first checked pair whose balls are near and that `accept`s.
    pub fn find_near(
        &self,
        centers: &Centers,
        accept: impl Fn(&BodyPair) -> bool,
    ) -> Option<&BodyPair> {
        // The quick look reads signs, which what is no number does not have.
        let is_sound = centers.are_finite();
        (0..centers.count()).find_map(|a| {
            let center = centers.get(a);
            let (reaches, _) =
                self.reach_squared[a * self.stride..(a + 1) * self.stride].as_chunks::<LANES>();
            (a / LANES..reaches.len()).find_map(|block| {
                if is_sound && centers.are_apart(center, block, &reaches[block]) {
                    return None;
                }
                (0..LANES).find_map(|lane| {
                    let (b, reach) = (block * LANES + lane, reaches[block][lane]);
                    let is_near =
                        reach >= 0.0 && !exceeds(center.distance_squared(centers.get(b)), reach);
                    if !is_near {
                        return None;
                    }
                    Some(&self.checked[self.places[a * self.stride + b] as usize])
                        .filter(|pair| accept(pair))
                })
            })
        })
    }

    /// Heap bytes.
    pub fn bytes(&self) -> usize {
        let tables =
            size_of_val(self.reach_squared.as_slice()) + size_of_val(self.places.as_slice());
        size_of_val(self.checked.as_slice()) + size_of_val(self.allowed.as_slice()) + tables
    }
}

/// The poses in the configurations that decide: whether a pair may touch by the robot with its
/// locked joints as joints, since a pair does not become one of neighbours because what lies
/// between is held still.
struct Survey {
    /// The frames of all bodies' nodes at zero.
    zero: Vec<Pose>,
    /// The same in each random configuration.
    samples: Vec<Vec<Pose>>,
    /// The links of the robot as it stands.
    standing: Vec<Pose>,
}

impl Survey {
    fn new(model: &RobotModel, unlocked: &RobotModel, bodies: &[CollisionBody]) -> Self {
        let zero: Vec<f64> =
            unlocked.joints.iter().map(|joint| 0f64.clamp(joint.lower, joint.upper)).collect();
        let sample_count = if bodies.len() > 1 { SAMPLES } else { 0 };
        let kinematics = Kinematics::new(unlocked);
        let links_from_nodes: Vec<Pose> =
            bodies.iter().map(|body| body.node_from_link.inverse()).collect();
        let node_poses = |q: &[f64]| -> Vec<Pose> {
            let links = link_poses(&kinematics, q);
            bodies
                .iter()
                .zip(&links_from_nodes)
                .map(|(body, link_from_node)| links[body.link] * *link_from_node)
                .collect()
        };
        let samples =
            (0..sample_count).map(|index| node_poses(&random_q(unlocked, index))).collect();
        Self {
            zero: node_poses(&zero),
            samples,
            standing: link_poses(&Kinematics::new(model), &model.standing_q),
        }
    }

    fn touches_standing(&self, a: &CollisionBody, b: &CollisionBody) -> bool {
        bodies_within(a, &self.standing[a.node_link], b, &self.standing[b.node_link], 0.0)
    }

    fn hits(&self, bodies: &[CollisionBody], pair: [usize; 2]) -> usize {
        self.samples.iter().filter(|poses| touch(bodies, pair, poses)).count()
    }
}

fn link_poses(kinematics: &Kinematics, q: &[f64]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; kinematics.links_len()];
    kinematics.forward(&Pose::IDENTITY, q, &mut poses);
    poses
}

fn random_q(model: &RobotModel, index: usize) -> Vec<f64> {
    let mut random = Random::new(0, Stream::Preparation, 0, index as u64);
    let turn = std::f64::consts::PI;
    model
        .joints
        .iter()
        .map(|joint| random.uniform(joint.lower.clamp(-turn, turn), joint.upper.clamp(-turn, turn)))
        .collect()
}

/// Whether two bodies touch, the nodes of all being at these poses.
fn touch(bodies: &[CollisionBody], [a, b]: [usize; 2], poses: &[Pose]) -> bool {
    bodies_within(&bodies[a], &poses[a], &bodies[b], &poses[b], 0.0)
}

/// `clearance`, or half of the pair's distance in a posture where that is less (to within a
/// nanometre, from below).
fn clearance_at_rest(
    a: &CollisionBody,
    b: &CollisionBody,
    standing: &[Pose],
    clearance: f64,
) -> f64 {
    let is_free = |margin: f64| {
        !bodies_within(a, &standing[a.node_link], b, &standing[b.node_link], 2.0 * margin)
    };
    if is_free(clearance) {
        return clearance;
    }
    let (mut free, mut hit) = (0.0, clearance);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (free + hit);
        if is_free(middle) { free = middle } else { hit = middle }
    }
    free
}

/// Where two bodies of one part each are apart as the robot stands.
fn standing_separation(
    a: &CollisionBody,
    b: &CollisionBody,
    standing: &[Pose],
) -> Option<SeparatingDirection> {
    let ([part_a], [part_b]) = (a.parts.as_slice(), b.parts.as_slice()) else { return None };
    if part_a.core_segment.is_some() || part_b.core_segment.is_some() {
        return None;
    }
    let [from_a, from_b] = [(a, part_a), (b, part_b)]
        .map(|(body, part)| standing[body.node_link] * part.node_from_part);
    SeparatingDirection::beyond(
        part_a,
        separating_direction(&part_a.solid, &part_b.solid, &from_a.inv_mul(&from_b))?,
    )
}

/// Whether two bodies come within `margin` of each other, their nodes being at these poses.
pub fn bodies_within(
    a: &CollisionBody,
    world_from_a: &Pose,
    b: &CollisionBody,
    world_from_b: &Pose,
    margin: f64,
) -> bool {
    let (world_from_a, world_from_b) = (affine(world_from_a), affine(world_from_b));
    let reach = a.sphere.radius + b.sphere.radius + margin;
    let centers = [
        world_from_a.transform_point3(a.sphere.center),
        world_from_b.transform_point3(b.sphere.center),
    ];
    !exceeds(centers[0].distance_squared(centers[1]), reach * reach)
        && parts_within((a, &world_from_a), (b, &world_from_b), margin)
}

/// The same, of bodies whose balls are known to be near; their nodes' frames are given in any
/// common one.
fn parts_within(
    a: (&CollisionBody, &DAffine3),
    b: (&CollisionBody, &DAffine3),
    margin: f64,
) -> bool {
    b.0.parts.iter().any(|part_b| {
        let center_b = b.1.transform_point3(part_b.sphere.center);
        a.0.parts.iter().any(|part_a| {
            let reach = part_a.sphere.radius + part_b.sphere.radius + margin;
            let center_a = a.1.transform_point3(part_a.sphere.center);
            let is_near = !exceeds((center_b - center_a).length_squared(), reach * reach);
            is_near && two_parts_within((part_a, a.1), (part_b, b.1), margin)
        })
    })
}

/// The same of two parts whose balls are known to be near.
fn two_parts_within(a: (&Part, &DAffine3), b: (&Part, &DAffine3), margin: f64) -> bool {
    match (&a.0.core_segment, &b.0.core_segment) {
        // These are their own balls.
        (Some(core_a), Some(core_b)) if core_a.is_point() && core_b.is_point() => true,
        (Some(core_a), Some(core_b)) => {
            let reach = a.0.solid.radius() + b.0.solid.radius() + margin;
            !exceeds(
                segment_segment_distance_squared(core_a.placed(a.1), core_b.placed(b.1)),
                reach * reach,
            )
        }
        (_, Some(core_segment)) => {
            a.0.is_within_of_segment(a.1, core_segment.placed(b.1), b.0.solid.radius() + margin)
        }
        (Some(core_segment), _) => {
            b.0.is_within_of_segment(b.1, core_segment.placed(a.1), a.0.solid.radius() + margin)
        }
        (None, None) => {
            let [from_a, from_b] = [a, b].map(|(part, frame)| pose(frame) * part.node_from_part);
            is_within(&a.0.solid, &b.0.solid, &from_a.inv_mul(&from_b), margin)
        }
    }
}
