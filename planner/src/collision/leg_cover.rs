//! How well collision shapes cover the curve along a leg: from a point of the root over the joints
//! and the ankle to the sole's origin.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{LimbIndex, RobotModel};

use crate::collision::robot_bodies::CollisionBody;
use crate::geometry::distance::LineSegment;
use crate::kinematics::forward::Kinematics;
use crate::kinematics::tree::{KinematicTree, affine};

/// Distance between two points of the curve that are tested, m.
const SPACING: f64 = 2.5e-3;
/// Distance below which two joints are at one point, m.
const SAME_POINT: f64 = 1e-6;

/// A robot with its legs stretched, in the root frame.
struct Stretched<'a> {
    model: &'a RobotModel,
    tree: &'a KinematicTree,
    bodies: &'a [CollisionBody],
    root_from_links: Vec<Pose>,
}

/// A straight piece of the curve, in the frame of a node that moves it.
#[derive(Debug, Clone, Copy)]
struct Piece {
    node: usize,
    /// Its ends, in the root frame of the stretched robot, m.
    ends: [DVec3; 2],
}

/// The longest part of the curve along either leg from a point of the root that no collision shape
/// covers in every posture, m. Allocates.
pub(crate) fn leg_gap(
    model: &RobotModel,
    tree: &KinematicTree,
    bodies: &[CollisionBody],
    root_point: DVec3,
) -> f64 {
    let mut root_from_links = vec![Pose::IDENTITY; model.links.len()];
    let legs: Vec<usize> = (0..model.feet.len()).flat_map(|limb| model.leg(limb)).collect();
    let standing = model.standing_q.iter().enumerate();
    let q: Vec<f64> = standing
        .map(|(joint, &position)| if legs.contains(&joint) { 0.0 } else { position })
        .collect();
    Kinematics::new(model).forward(&Pose::IDENTITY, &q, &mut root_from_links);
    let robot = Stretched { model, tree, bodies, root_from_links };
    (0..model.feet.len()).map(|limb| robot.gap(limb, root_point)).fold(0.0, f64::max)
}

impl Stretched<'_> {
    /// The longest uncovered part of the curve along one leg, m.
    fn gap(&self, limb: LimbIndex, root_point: DVec3) -> f64 {
        let pieces = self.pieces(limb, root_point);
        let balls = self.balls(&pieces);
        let (mut run, mut longest) = (0.0, 0.0);
        for (index, piece) in pieces.iter().enumerate() {
            let [from, to] = piece.ends;
            let length = from.distance(to);
            let count = libm::ceil(length / SPACING).max(1.0);
            for step in 0..=count as usize {
                let point = from.lerp(to, step as f64 / count);
                let is_in_ball = point.distance(from) < balls[index]
                    || balls.get(index + 1).is_some_and(|ball| point.distance(to) < *ball);
                let is_covered = is_in_ball || self.covers(piece.node, point);
                run = if is_covered { 0.0 } else { run + length / count };
                longest = f64::max(longest, run);
            }
        }
        longest + SPACING
    }

    /// The pieces of the curve along one leg.
    fn pieces(&self, limb: LimbIndex, root_point: DVec3) -> Vec<Piece> {
        let foot = &self.model.feet[limb];
        let sole = (self.root_from_links[foot.link] * foot.link_from_sole).translation;
        let mut pieces = vec![];
        let (mut node, mut from) = (0, root_point);
        for joint in self.model.leg(limb) {
            let child = self.model.joints[joint].child;
            let to = self.root_from_links[child].translation;
            pieces.push(Piece { node, ends: [from, to] });
            (node, from) = (self.tree.of_link(child).0, to);
        }
        pieces.push(Piece { node, ends: [from, sole] });
        pieces
    }

    /// For the beginning of each piece: the radius of a ball about it that a shape contains in
    /// every posture, m. Joints at one point share it.
    fn balls(&self, pieces: &[Piece]) -> Vec<f64> {
        let own = |index: usize| {
            let nodes = [index.saturating_sub(1), index].map(|piece| pieces[piece].node);
            nodes.map(|node| self.ball(node, pieces[index].ends[0])).into_iter().fold(0.0, f64::max)
        };
        let own: Vec<f64> = (0..pieces.len()).map(own).collect();
        let at = |index: usize| pieces[index].ends[0];
        let are_one = |a: usize, b: usize| {
            (a.min(b)..a.max(b)).all(|index| at(index).distance(at(index + 1)) < SAME_POINT)
        };
        let shared = |index: usize| {
            let same = (0..own.len()).filter(|&other| are_one(index, other));
            same.map(|other| own[other]).fold(0.0, f64::max)
        };
        (0..own.len()).map(shared).collect()
    }

    /// The radius of a ball about a point that a sphere or capsule of a node contains, m.
    fn ball(&self, node: usize, point: DVec3) -> f64 {
        let bodies = self.bodies.iter().filter(|body| body.node == node);
        let depth = |body: &CollisionBody| {
            let point = self.root_from_links[body.node_link].inverse_transform_point(point);
            let parts = body.parts.iter().filter_map(|part| {
                let LineSegment { start, delta } = part.core_segment?;
                let along = (point - start).dot(delta) / delta.length_squared().max(1e-12);
                let nearest = start + along.clamp(0.0, 1.0) * delta;
                Some(part.solid.radius() - nearest.distance(point))
            });
            parts.fold(0.0, f64::max)
        };
        bodies.map(depth).fold(0.0, f64::max)
    }

    /// Whether a shape of a node contains a point.
    fn covers(&self, node: usize, point: DVec3) -> bool {
        let segment = LineSegment { start: point, delta: DVec3::ZERO };
        self.bodies.iter().filter(|body| body.node == node).any(|body| {
            let frame: DAffine3 = affine(&self.root_from_links[body.node_link]);
            body.parts.iter().any(|part| part.is_within_of_segment(&frame, segment, 0.0))
        })
    }
}
