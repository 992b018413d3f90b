//! A curve through the robot, from the ground that a foot touches to the root: how long it is, and
//! which of its points collision shapes cover.

use glam::{DAffine3, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::collision::model::CollisionModel;
use crate::kinematics::leg_joint::LEG_JOINTS_MAX;
use crate::kinematics::tree::NODES_MAX;
use crate::relaxation::tuning::{COVER_DEPTH, CURVE_SPACING, FOOT_DEPTH_MAX, SAME_POINT};
use crate::robot::bounding_spheres::BoundingSphere;
use crate::robot::mechanism::Mechanism;

/// Bounds of the curves of both legs in every configuration. A curve leads from a touched point to
/// a point in the foot's box, to the first covered point from the ankle on, from joint to joint,
/// and to the centre of a ball in the root.
///
/// A point from the ankle on is covered if it is [`COVER_DEPTH`] deep in shapes of its own link, or
/// in a ball about the nearest joint in an adjacent link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LegCurve {
    /// Distance from a touched point to a point in the foot's box, m.
    pub to_foot: f64,
    /// Depth of that point in the box, m.
    pub foot_depth: f64,
    /// Distance from there to the first covered point, m.
    pub to_leg: f64,
    /// Whether the first covered point is higher than the one in the foot.
    pub is_above: bool,
    /// Length from the first covered point to the centre of the ball, m.
    pub length: f64,
    /// The longest part of it that is not covered, m.
    pub gap: f64,
    /// Number of parts that are not covered.
    pub gaps: u32,
}

/// A part of the curve that is rigid with a node: a segment between two points in the frame of the
/// root with the legs at 0, and the radii of covered balls about both, m.
struct RigidPart {
    node: usize,
    ends: [DVec3; 2],
    balls: [f64; 2],
}

/// The curve from the ankle on, as far as it is followed.
#[derive(Default)]
struct Course {
    length: f64,
    /// Length before the first covered point, once there is one, m.
    lead: Option<f64>,
    /// Length of the part at its end that is not covered, m.
    open: f64,
    gap: f64,
    gaps: u32,
}

/// Points of a foot.
type FootPoints = BoundedVec<DVec3, POLYGON_VERTICES_MAX>;

/// One leg, its joints at 0.
struct LegAtZero<'a> {
    collision: &'a CollisionModel,
    root_from_nodes: [DAffine3; NODES_MAX],
    /// The root, and the nodes that the joints move, root first.
    nodes: BoundedVec<usize, { LEG_JOINTS_MAX + 1 }>,
    /// The points of the joints in the root frame, m.
    points: BoundedVec<DVec3, LEG_JOINTS_MAX>,
    /// The corners of the sole in the root frame, m.
    sole: FootPoints,
    /// The normal of the sole in the root frame.
    normal: DVec3,
}

impl LegCurve {
    /// The bounds of both legs on ground with slopes up to `steepest_tan`; `None` where a foot has
    /// no box, or a link between root and leg moves.
    pub fn of(
        robot: &Mechanism,
        collision: &CollisionModel,
        ball: &BoundingSphere,
        steepest_tan: f64,
    ) -> Option<Self> {
        let of_leg =
            |limb: usize| LegAtZero::new(robot, collision, limb)?.curve(ball, steepest_tan);
        let (left, right) = (of_leg(0)?, of_leg(1)?);
        Some(Self {
            to_foot: left.to_foot.max(right.to_foot),
            foot_depth: left.foot_depth.min(right.foot_depth),
            to_leg: left.to_leg.max(right.to_leg),
            is_above: left.is_above && right.is_above,
            length: left.length.max(right.length),
            gap: left.gap.max(right.gap),
            gaps: left.gaps.max(right.gaps),
        })
    }

    /// Length from a touched point to the centre of the ball, m.
    pub fn whole_length(&self) -> f64 {
        self.to_foot + self.to_leg + self.length
    }
}

impl<'a> LegAtZero<'a> {
    fn new(robot: &Mechanism, collision: &'a CollisionModel, limb: usize) -> Option<Self> {
        let (tree, leg) = (&robot.tree, &robot.legs[limb]);
        let mut q = robot.standing_q;
        leg.joints().iter().for_each(|joint| q[joint.index] = 0.0);
        let mut root_from_nodes = [DAffine3::IDENTITY; NODES_MAX];
        tree.place(0..tree.nodes().len(), &q, &mut root_from_nodes);
        let mut nodes = BoundedVec::new();
        nodes.push(0).ok()?;
        for joint in leg.joints() {
            let node = tree.nodes().iter().position(|node| node.joint == Some(joint.index))?;
            if nodes.last() != Some(&tree.nodes()[node].parent) {
                return None;
            }
            nodes.push(node).ok()?;
        }
        let root_from_sole = leg.root_from_sole(&q);
        let corners = robot.soles[limb].polygon.iter();
        Some(Self {
            collision,
            root_from_nodes,
            nodes,
            points: leg.joints().iter().map(|joint| joint.point).collect(),
            sole: corners.map(|corner| root_from_sole * corner.extend(0.0)).collect(),
            normal: root_from_sole.rotation * DVec3::Z,
        })
    }

    /// How deep a point lies in the links of a node, m.
    fn depth(&self, node: usize, point: DVec3) -> f64 {
        let node_from_root = self.root_from_nodes[node].inverse();
        self.collision.depth_in_node(node, node_from_root.transform_point3(point))
    }

    /// The radius of a ball about a joint's point that stays covered however the leg moves: joints
    /// at the same point turn about it.
    fn ball(&self, joint: usize) -> f64 {
        let point = self.points[joint];
        let is_here = |&other: &usize| self.points[other].distance(point) < SAME_POINT;
        let first = (0..joint).rev().take_while(is_here).last().unwrap_or(joint);
        let last = (joint..self.points.len()).take_while(is_here).last().unwrap_or(joint);
        let depths = self.nodes[first..last + 2].iter().map(|&node| self.depth(node, point));
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The points in a box of a node that are nearest to others, at most `depth_max` (m) below its
    /// surface, and their depth: for the box whose farthest one is nearest.
    fn in_box(&self, node: usize, points: &[DVec3], depth_max: f64) -> Option<(FootPoints, f64)> {
        let root_from_node = self.root_from_nodes[node];
        let boxes = self.collision.boxes_in_node(node).map(|(node_from_box, half_extents)| {
            let depth = depth_max.min(half_extents.min_element() - SAME_POINT);
            let half = half_extents - DVec3::splat(depth);
            let inside = points.iter().map(|point| {
                let in_node = root_from_node.inverse().transform_point3(*point);
                let local = node_from_box.inverse() * in_node;
                root_from_node.transform_point3(node_from_box * local.clamp(-half, half))
            });
            (inside.collect::<FootPoints>(), depth)
        });
        boxes.min_by(|a, b| farthest(points, &a.0).total_cmp(&farthest(points, &b.0)))
    }

    /// The bounds of the curves from the sole to the centre of a ball in the root.
    fn curve(&self, ball: &BoundingSphere, steepest_tan: f64) -> Option<LegCurve> {
        let last = self.points.len() - 1;
        let ankle = self.points[last];
        let (inside, foot_depth) = self.in_box(self.nodes[last + 1], &self.sole, FOOT_DEPTH_MAX)?;
        let course = self.course(ball);
        let lead = course.lead.filter(|_| course.open == 0.0)?;
        let is_above = inside.iter().all(|point| {
            let up = (ankle - *point).dot(self.normal);
            let across = (ankle - *point).reject_from(self.normal).length();
            up >= across * steepest_tan
        });
        let to_ankle = inside.iter().map(|point| point.distance(ankle)).fold(0.0, f64::max);
        Some(LegCurve {
            to_foot: farthest(&self.sole, &inside),
            foot_depth,
            to_leg: to_ankle + lead,
            is_above: is_above && lead == 0.0,
            length: course.length - lead,
            gap: course.gap,
            gaps: course.gaps,
        })
    }

    /// The curve from the ankle to the centre of a ball in the root, by way of the covered point of
    /// the root's boxes that is nearest to the hip.
    fn course(&self, ball: &BoundingSphere) -> Course {
        let mut course = Course::default();
        for joint in (0..self.points.len() - 1).rev() {
            let ends = [self.points[joint + 1], self.points[joint]];
            let balls = [self.ball(joint + 1), self.ball(joint)];
            self.follow(&RigidPart { node: self.nodes[joint + 1], ends, balls }, &mut course);
        }
        let hip = self.points[0];
        let by = self.in_box(0, &[hip], COVER_DEPTH + SAME_POINT);
        let by = by.filter(|(_, depth)| *depth >= COVER_DEPTH).map(|(points, _)| points[0]);
        let by = by.unwrap_or(ball.center);
        for (ends, balls) in [([hip, by], [self.ball(0), 0.0]), ([by, ball.center], [0.0; 2])] {
            self.follow(&RigidPart { node: 0, ends, balls }, &mut course);
        }
        course
    }

    /// Adds a part to a curve.
    fn follow(&self, part: &RigidPart, course: &mut Course) {
        let [from, to] = part.ends;
        let length = from.distance(to);
        let intervals = libm::ceil(length / CURVE_SPACING).max(1.0);
        let spacing = length / intervals;
        for index in 0..=intervals as usize {
            let along = index as f64 * spacing;
            let depth = self
                .depth(part.node, from.lerp(to, index as f64 / intervals))
                .max(part.balls[0] - along)
                .max(part.balls[1] - (length - along));
            if depth >= COVER_DEPTH {
                course.lead.get_or_insert(course.length + along);
                course.open = 0.0;
            } else if course.lead.is_some() {
                course.gaps += u32::from(course.open == 0.0);
                // From the last covered sample to the next one.
                course.open += if course.open == 0.0 { 2.0 * spacing } else { spacing };
                course.gap = course.gap.max(course.open);
            }
        }
        course.length += length;
    }
}

/// The greatest distance of corresponding points, m.
fn farthest(points: &[DVec3], others: &[DVec3]) -> f64 {
    points.iter().zip(others).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}
