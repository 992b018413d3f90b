//! The robot's kinematic tree in the root frame, as the search uses it.
//!
//! A node is a link that moves, with all links fixed to it. The nodes that no leg moves, the
//! upper-body nodes, stand first; their frames change only with their own joints.

use glam::{DAffine3, DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::robot::model::{JointIndex, JointKind, RobotModel};

/// Most nodes: the root and one for each joint.
pub const NODES_MAX: usize = JOINTS_MAX + 1;

/// The tree of nodes. Parents stand before their children; node 0 is the root.
#[derive(Debug, Clone)]
pub struct KinematicTree {
    nodes: Vec<KinematicNode>,
    upper_body_len: usize,
    of_links: Vec<(usize, Pose)>,
}

/// A link that moves against its parent, or the root, with all links fixed to it.
#[derive(Debug, Clone)]
pub struct KinematicNode {
    /// Index of the link.
    pub link: usize,
    /// The parent node; the root's is itself.
    pub parent: usize,
    /// The joint that moves it; `None` for the root.
    pub joint: Option<JointIndex>,
    /// Mass of all its links, kg.
    pub mass: f64,
    /// Their centre of mass in the node's frame, m; the origin if they have no mass.
    pub com: DVec3,
    parent_from_joint: DAffine3,
    /// Whether the joint frame is rotated against the parent's.
    is_rotated: bool,
    motion: JointMotion,
}

#[derive(Debug, Clone, Copy)]
enum JointMotion {
    RotationAboutX(f64),
    RotationAboutY(f64),
    RotationAboutZ(f64),
    Rotation(DVec3),
    Translation(DVec3),
}

impl KinematicTree {
    /// Compiles a robot.
    pub fn new(model: &RobotModel) -> Self {
        let legs: Vec<_> = model.feet.iter().flat_map(|foot| model.chain(foot.link)).collect();
        let is_upper_body =
            |link: usize| model.chain(link).iter().all(|joint| !legs.contains(joint));
        let moves =
            |link: &usize| model.links[*link].parent.as_ref().is_none_or(|at| at.joint.is_some());
        let mut order: Vec<usize> = (0..model.links.len()).filter(moves).collect();
        order.sort_by_key(|&link| !is_upper_body(link));
        let mut of_links = vec![(0, Pose::IDENTITY); model.links.len()];
        for (index, link) in model.links.iter().enumerate() {
            of_links[index] = match &link.parent {
                Some(at) if at.joint.is_none() => {
                    let (node, node_from_parent): (usize, Pose) = of_links[at.parent];
                    (node, node_from_parent * at.parent_from_joint)
                }
                _ => (order.iter().position(|&other| other == index).unwrap_or(0), Pose::IDENTITY),
            };
        }
        let nodes = order.iter().map(|&link| KinematicNode::new(model, link, &of_links)).collect();
        Self {
            nodes,
            upper_body_len: order.iter().filter(|&&link| is_upper_body(link)).count(),
            of_links,
        }
    }

    /// All nodes.
    pub fn nodes(&self) -> &[KinematicNode] {
        &self.nodes
    }

    /// Number of upper-body nodes, which stand first.
    pub fn upper_body_len(&self) -> usize {
        self.upper_body_len
    }

    /// The node of a link, and the link's pose in the node's frame.
    pub fn of_link(&self, link: usize) -> (usize, Pose) {
        self.of_links[link]
    }

    /// The joints of the upper-body nodes.
    pub fn upper_body_joints(&self) -> impl Iterator<Item = JointIndex> + '_ {
        self.nodes[..self.upper_body_len].iter().filter_map(|node| node.joint)
    }

    /// Writes the frames of a range of nodes; the frames of all nodes before it must be valid.
    pub fn place(
        &self,
        range: std::ops::Range<usize>,
        q: &[f64],
        root_from_nodes: &mut [DAffine3],
    ) {
        for index in range {
            let node = &self.nodes[index];
            root_from_nodes[index] = match node.joint {
                Some(joint) => node.after(&root_from_nodes[node.parent], q[joint]),
                None => DAffine3::IDENTITY,
            };
        }
    }

    /// First mass moment (kg m, root frame) of a range of nodes.
    pub fn moment(&self, range: std::ops::Range<usize>, root_from_nodes: &[DAffine3]) -> DVec3 {
        let placed = self.nodes[range.clone()].iter().zip(&root_from_nodes[range]);
        placed.map(|(node, frame)| frame.transform_point3(node.com) * node.mass).sum()
    }

    /// First mass moment (kg m, root frame) of all nodes at joint positions `q`.
    pub fn total_moment(&self, q: &[f64]) -> DVec3 {
        let count = self.nodes.len();
        let mut root_from_nodes = vec![DAffine3::IDENTITY; count];
        self.place(0..count, q, &mut root_from_nodes);
        self.moment(0..self.upper_body_len, &root_from_nodes)
            + self.moment(self.upper_body_len..count, &root_from_nodes)
    }
}

impl KinematicNode {
    fn new(model: &RobotModel, link: usize, of_links: &[(usize, Pose)]) -> Self {
        let (mut mass, mut moment) = (0.0, DVec3::ZERO);
        let node = of_links[link].0;
        for (part, (_, node_from_part)) in
            model.links.iter().zip(of_links).filter(|(_, (of, _))| *of == node)
        {
            mass += part.mass;
            moment += (*node_from_part * part.com) * part.mass;
        }
        let com = if mass > 0.0 { moment / mass } else { DVec3::ZERO };
        let root = Self {
            link,
            parent: 0,
            joint: None,
            mass,
            com,
            parent_from_joint: DAffine3::IDENTITY,
            is_rotated: false,
            motion: JointMotion::Translation(DVec3::ZERO),
        };
        let Some(at) = &model.links[link].parent else { return root };
        let (parent, node_from_parent) = of_links[at.parent];
        let parent_from_joint = node_from_parent * at.parent_from_joint;
        let motion = at.joint.map_or(root.motion, |joint| {
            JointMotion::new(model.joints[joint].kind, model.joints[joint].axis)
        });
        let is_rotated = parent_from_joint.rotation != glam::DQuat::IDENTITY;
        Self {
            parent,
            joint: at.joint,
            parent_from_joint: affine(&parent_from_joint),
            is_rotated,
            motion,
            ..root
        }
    }

    /// The node's frame for its parent's frame `parent` and its joint's position `q`.
    fn after(&self, parent: &DAffine3, q: f64) -> DAffine3 {
        let translation = parent.matrix3 * self.parent_from_joint.translation + parent.translation;
        let r = if self.is_rotated {
            parent.matrix3 * self.parent_from_joint.matrix3
        } else {
            parent.matrix3
        };
        let rotated = |sign: f64| libm::sincos(sign * q);
        let matrix3 = match self.motion {
            JointMotion::RotationAboutX(sign) => {
                let (s, c) = rotated(sign);
                DMat3::from_cols(r.x_axis, c * r.y_axis + s * r.z_axis, c * r.z_axis - s * r.y_axis)
            }
            JointMotion::RotationAboutY(sign) => {
                let (s, c) = rotated(sign);
                DMat3::from_cols(c * r.x_axis - s * r.z_axis, r.y_axis, c * r.z_axis + s * r.x_axis)
            }
            JointMotion::RotationAboutZ(sign) => {
                let (s, c) = rotated(sign);
                DMat3::from_cols(c * r.x_axis + s * r.y_axis, c * r.y_axis - s * r.x_axis, r.z_axis)
            }
            JointMotion::Rotation(axis) => r * DMat3::from_quat(rotation_about(axis, q)),
            JointMotion::Translation(axis) => {
                return DAffine3 { matrix3: r, translation: translation + r * (axis * q) };
            }
        };
        DAffine3 { matrix3, translation }
    }
}

impl JointMotion {
    fn new(kind: JointKind, axis: DVec3) -> Self {
        let is_along = |unit: DVec3| axis == unit || axis == -unit;
        match kind {
            JointKind::Prismatic => Self::Translation(axis),
            JointKind::Revolute if is_along(DVec3::X) => Self::RotationAboutX(axis.x),
            JointKind::Revolute if is_along(DVec3::Y) => Self::RotationAboutY(axis.y),
            JointKind::Revolute if is_along(DVec3::Z) => Self::RotationAboutZ(axis.z),
            JointKind::Revolute => Self::Rotation(axis),
        }
    }
}

/// A pose as an affine transformation.
pub fn affine(pose: &Pose) -> DAffine3 {
    DAffine3 { matrix3: DMat3::from_quat(pose.rotation), translation: pose.translation }
}

/// An affine transformation without scale as a pose.
pub fn pose(affine: &DAffine3) -> Pose {
    Pose::from_parts(affine.translation, glam::DQuat::from_mat3(&affine.matrix3))
}
