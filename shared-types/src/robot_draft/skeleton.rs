//! The kinematic tree of a URDF, before a robot file says which of its joints are used.

use std::f64::consts::PI;

use glam::DVec3;

use crate::base::spatial::Pose;
use crate::robot::model::JointKind;
use crate::robot::tree::TreeLink;
use crate::robot::urdf::Urdf;
use crate::robot::urdf_joint::{JointType, UrdfJoint};

/// Where a joint turns whose range is not stated, rad either way: an estimate.
pub(crate) const RANGE: f64 = std::f64::consts::FRAC_PI_2;
/// Axes that cross at a smaller angle have no certain point of crossing, as its sine squared.
const CROSSING_MIN: f64 = 0.5;

/// Index into [`Skeleton::nodes`].
pub(crate) type NodeIndex = usize;

/// All links, parents first.
pub(crate) struct Skeleton<'a> {
    pub(crate) urdf: &'a Urdf,
    pub(crate) nodes: Vec<Node>,
}

/// A link and the joint above it.
pub(crate) struct Node {
    pub(crate) urdf_link: usize,
    pub(crate) parent: Option<NodeIndex>,
    pub(crate) parent_from_joint: Pose,
    /// The joint above it, if it moves.
    pub(crate) joint: Option<NodeJoint>,
}

/// A joint that moves.
#[derive(Debug, Clone)]
pub(crate) struct NodeJoint {
    pub(crate) urdf_joint: usize,
    pub(crate) kind: JointKind,
    pub(crate) axis: DVec3,
    /// Finite limits, rad or m: estimates where the file states none.
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// The node whose joint it mimics, with multiplier and offset.
    pub(crate) follows: Option<(NodeIndex, f64, f64)>,
}

impl<'a> Skeleton<'a> {
    pub(crate) fn new(urdf: &'a Urdf, tree: &[TreeLink]) -> Self {
        let node = |link: &TreeLink| Node {
            urdf_link: link.urdf_link,
            parent: link.parent.map(|(parent, _)| parent),
            parent_from_joint: link
                .parent
                .map_or(Pose::IDENTITY, |(_, joint)| urdf.joints[joint].parent_from_joint),
            joint: link.parent.and_then(|(_, joint)| node_joint(&urdf.joints[joint], joint)),
        };
        let mut skeleton = Self { urdf, nodes: tree.iter().map(node).collect() };
        skeleton.resolve_mimics();
        skeleton
    }

    fn resolve_mimics(&mut self) {
        for at in 0..self.nodes.len() {
            let Some(joint) = &self.nodes[at].joint else { continue };
            let Some(mimic) = &self.urdf.joints[joint.urdf_joint].mimic else { continue };
            let leader = (0..self.nodes.len())
                .find(|other| *other != at && self.joint_name(*other) == Some(&mimic.joint));
            let follows = leader.map(|leader| (leader, mimic.multiplier, mimic.offset));
            if let Some(joint) = &mut self.nodes[at].joint {
                joint.follows = follows;
            }
        }
    }

    /// The name of a node's link.
    pub(crate) fn link_name(&self, node: NodeIndex) -> &str {
        &self.urdf.links[self.nodes[node].urdf_link].name
    }

    /// Whether the joint above a node mimics another one.
    pub(crate) fn is_mimic(&self, node: NodeIndex) -> bool {
        self.nodes[node].joint.as_ref().is_some_and(|joint| joint.follows.is_some())
    }

    /// The name of the moving joint above a node.
    pub(crate) fn joint_name(&self, node: NodeIndex) -> Option<&String> {
        let joint = self.nodes[node].joint.as_ref()?;
        Some(&self.urdf.joints[joint.urdf_joint].name)
    }

    /// The joint above a node as the file states it.
    pub(crate) fn urdf_joint(&self, node: NodeIndex) -> Option<&UrdfJoint> {
        let joint = self.nodes[node].joint.as_ref()?;
        Some(&self.urdf.joints[joint.urdf_joint])
    }

    /// Positions of all nodes' joints, each as near to 0 as its limits allow.
    pub(crate) fn neutral(&self) -> Vec<f64> {
        let neutral = |node: &Node| {
            node.joint.as_ref().map_or(0.0, |joint| 0.0_f64.clamp(joint.lower, joint.upper))
        };
        let mut positions: Vec<f64> = self.nodes.iter().map(neutral).collect();
        self.follow(&mut positions);
        positions
    }

    /// Moves the joints that mimic others.
    fn follow(&self, positions: &mut [f64]) {
        for at in 0..self.nodes.len() {
            let follows = self.nodes[at].joint.as_ref().and_then(|joint| joint.follows);
            if let Some((leader, multiplier, offset)) = follows {
                positions[at] = multiplier * positions[leader] + offset;
            }
        }
    }

    /// The pose of every link in the root link's frame.
    pub(crate) fn poses(&self, positions: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.nodes.len());
        for (node, position) in self.nodes.iter().zip(positions) {
            let parent = node.parent.map_or(Pose::IDENTITY, |parent| poses[parent]);
            let motion = node
                .joint
                .as_ref()
                .map_or(Pose::IDENTITY, |joint| joint.kind.motion(joint.axis, *position));
            poses.push(parent * node.parent_from_joint * motion);
        }
        poses
    }

    /// Where the joint above a node turns, root frame: the point of its axis nearest to the axis of
    /// the moving joint above. A URDF may put a joint's frame anywhere on its axis. The origin of
    /// the link where the two axes are nearly parallel, or one of the joints does not turn.
    pub(crate) fn joint_point(&self, poses: &[Pose], node: NodeIndex) -> DVec3 {
        let origin = poses[node].translation;
        let above = self.nodes[node].parent.map(|parent| self.body(parent));
        let axes = [Some(node), above].map(|node| node.and_then(|it| self.axis(poses, it)));
        let (Some(above), [Some(axis), Some(other)]) = (above, axes) else { return origin };
        let cos = axis.dot(other);
        let sin_squared = 1.0 - cos * cos;
        if sin_squared < CROSSING_MIN {
            return origin;
        }
        let across = poses[above].translation - origin;
        origin + (across.dot(axis) - across.dot(other) * cos) / sin_squared * axis
    }

    /// The axis about which a node turns, root frame.
    fn axis(&self, poses: &[Pose], node: NodeIndex) -> Option<DVec3> {
        let joint = self.nodes[node].joint.as_ref()?;
        (joint.kind == JointKind::Revolute).then(|| poses[node].rotation * joint.axis)
    }

    /// The nodes with moving joints from the root to a node, root first.
    pub(crate) fn chain(&self, node: NodeIndex) -> Vec<NodeIndex> {
        let mut chain: Vec<NodeIndex> = self.path(node);
        chain.retain(|at| self.nodes[*at].joint.is_some());
        chain
    }

    /// All nodes from the root to a node.
    fn path(&self, node: NodeIndex) -> Vec<NodeIndex> {
        let mut path: Vec<NodeIndex> =
            std::iter::successors(Some(node), |at| self.nodes[*at].parent).collect();
        path.reverse();
        path
    }

    /// Whether a node hangs on another one, or is that one.
    pub(crate) fn is_below(&self, node: NodeIndex, above: NodeIndex) -> bool {
        std::iter::successors(Some(node), |at| self.nodes[*at].parent).any(|at| at == above)
    }

    /// The node that carries all links fixed to a node, itself among them.
    pub(crate) fn body(&self, node: NodeIndex) -> NodeIndex {
        let mut at = node;
        while let (None, Some(parent)) = (&self.nodes[at].joint, self.nodes[at].parent) {
            at = parent;
        }
        at
    }

    /// The nodes fixed to a body, the body first.
    pub(crate) fn body_nodes(&self, body: NodeIndex) -> Vec<NodeIndex> {
        (body..self.nodes.len()).filter(|at| self.body(*at) == body).collect()
    }

    /// The bodies that move against their parents.
    pub(crate) fn moving(&self) -> impl Iterator<Item = NodeIndex> {
        (0..self.nodes.len()).filter(|at| self.nodes[*at].joint.is_some())
    }

    /// The mass of the links below a node, itself included, kg.
    pub(crate) fn mass_below(&self, node: NodeIndex) -> f64 {
        let below = (node..self.nodes.len()).filter(|at| self.is_below(*at, node));
        below.map(|at| self.urdf.links[self.nodes[at].urdf_link].mass).sum()
    }

    /// The centre of mass for these poses, root frame, m; the origin if nothing has mass.
    pub(crate) fn centre_of_mass(&self, poses: &[Pose]) -> DVec3 {
        self.centre_of_mass_of(poses, |_| true)
    }

    /// The centre of mass of some nodes, root frame, m; the origin if nothing has mass.
    pub(crate) fn centre_of_mass_of(
        &self,
        poses: &[Pose],
        is_counted: impl Fn(NodeIndex) -> bool,
    ) -> DVec3 {
        let (mut moment, mut mass) = (DVec3::ZERO, 0.0);
        for node in (0..self.nodes.len()).filter(|node| is_counted(*node)) {
            let link = &self.urdf.links[self.nodes[node].urdf_link];
            moment += link.mass * (poses[node] * link.link_from_com.translation);
            mass += link.mass;
        }
        if mass > 0.0 { moment / mass } else { DVec3::ZERO }
    }
}

/// Whether a joint turns, but nothing says how far: its `<limit>` states no range, or it is a
/// continuous one without a `<limit>`, as simulators' tools write all joints.
pub(crate) fn lacks_range(joint: &UrdfJoint) -> bool {
    match (joint.joint_type, &joint.limit) {
        (JointType::Revolute, Some(limit)) => limit.range.is_none(),
        (JointType::Continuous, None) => true,
        _ => false,
    }
}

/// A joint that moves; `None` for the others.
fn node_joint(joint: &UrdfJoint, urdf_joint: usize) -> Option<NodeJoint> {
    let kind = match joint.joint_type {
        JointType::Revolute | JointType::Continuous => JointKind::Revolute,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Fixed | JointType::Floating | JointType::Planar => return None,
    };
    let range = joint.limit.as_ref().and_then(|limit| limit.range);
    let turn = if lacks_range(joint) { RANGE } else { PI };
    let (lower, upper) = range.unwrap_or((-turn, turn));
    let (lower, upper) = (lower.clamp(-PI, PI), upper.clamp(-PI, PI));
    let (lower, upper) = if lower <= upper { (lower, upper) } else { (0.0, 0.0) };
    Some(NodeJoint { urdf_joint, kind, axis: joint.axis, lower, upper, follows: None })
}
