//! The robot's masses and joint efforts, compiled for gravity torques.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::robot::model::{JointIndex, JointKind, RobotModel};

use crate::kinematics::tree::{KinematicTree, NODES_MAX};

/// The masses of all nodes, and the joints with the mass that each carries.
#[derive(Debug, Clone)]
pub struct MassTree {
    nodes: Vec<MassNode>,
    upper_body_len: usize,
    /// Joints of the upper-body nodes. The loads on the feet do not change their torques.
    upper_body_joints: Vec<LoadedJoint>,
    /// All other joints.
    leg_joints: Vec<LoadedJoint>,
    mass: f64,
}

#[derive(Debug, Clone)]
struct MassNode {
    parent: usize,
    mass: f64,
    com: DVec3,
}

/// A joint with the mass and the feet beyond it, seen from the root.
#[derive(Debug, Clone)]
pub(crate) struct LoadedJoint {
    /// Index into `q`.
    pub(crate) joint: JointIndex,
    /// The node that it moves.
    pub(crate) node: usize,
    axis: DVec3,
    kind: JointKind,
    /// Mass beyond it, kg.
    pub(crate) mass: f64,
    /// Effort that may be used, N m or N.
    pub(crate) effort: f64,
    /// By limb: whether the foot is beyond it.
    pub(crate) carries: [bool; 2],
}

/// Lever arm of gravity on each upper-body joint in the root frame, kg m (revolute) or kg
/// (prismatic). The joint's torque or force is `-gravity` times the arm's vertical component.
pub(crate) type LeverArms = heapless::Vec<DVec3, JOINTS_MAX>;

impl MassTree {
    /// Multiplies all usable efforts.
    pub(crate) fn scale_efforts(&mut self, factor: f64) {
        let joints = self.upper_body_joints.iter_mut().chain(&mut self.leg_joints);
        joints.for_each(|joint| joint.effort *= factor);
    }

    /// Compiles a robot; only `effort_share` (0 to 1) of each joint's effort may be used.
    pub fn new(model: &RobotModel, effort_share: f64) -> Self {
        let tree = KinematicTree::new(model);
        let nodes: Vec<_> = tree
            .nodes()
            .iter()
            .map(|node| MassNode { parent: node.parent, mass: node.mass, com: node.com })
            .collect();
        let mut masses: Vec<f64> = nodes.iter().map(|node| node.mass).collect();
        for index in (1..nodes.len()).rev() {
            masses[nodes[index].parent] += masses[index];
        }
        let chains: Vec<_> = model.feet.iter().map(|foot| model.chain(foot.link)).collect();
        let loaded_joint = |(node, joint): (usize, usize)| LoadedJoint {
            joint,
            node,
            axis: model.joints[joint].axis,
            kind: model.joints[joint].kind,
            mass: masses[node],
            effort: model.joints[joint].effort * effort_share,
            carries: [0, 1]
                .map(|limb| chains.get(limb).is_some_and(|chain| chain.contains(&joint))),
        };
        let joints =
            tree.nodes().iter().enumerate().filter_map(|(index, node)| Some((index, node.joint?)));
        let (upper_body_joints, leg_joints) = joints
            .map(loaded_joint)
            .partition(|joint: &LoadedJoint| joint.node < tree.upper_body_len());
        Self {
            nodes,
            upper_body_len: tree.upper_body_len(),
            upper_body_joints,
            leg_joints,
            mass: masses[0],
        }
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Torque (N m) or force (N) of a joint that may be used; 0 for an unknown joint.
    pub fn usable_effort(&self, joint: JointIndex) -> f64 {
        self.joint(joint).map_or(0.0, |joint| joint.effort)
    }

    /// Mass beyond a joint, seen from the root, kg; 0 for an unknown joint.
    pub fn carried_mass(&self, joint: JointIndex) -> f64 {
        self.joint(joint).map_or(0.0, |joint| joint.mass)
    }

    fn joint(&self, index: JointIndex) -> Option<&LoadedJoint> {
        self.upper_body_joints.iter().chain(&self.leg_joints).find(|joint| joint.joint == index)
    }

    /// Joints of the upper-body nodes.
    pub(crate) fn upper_body_joints(&self) -> &[LoadedJoint] {
        &self.upper_body_joints
    }

    /// All other joints.
    pub(crate) fn leg_joints(&self) -> &[LoadedJoint] {
        &self.leg_joints
    }

    /// Writes the lever arms of the upper-body joints, for these frames of the upper-body nodes.
    pub(crate) fn update_lever_arms(
        &self,
        root_from_nodes: &[DAffine3],
        lever_arms: &mut LeverArms,
    ) {
        let moments = self.subtree_moments(0..self.upper_body_len, root_from_nodes);
        lever_arms.clear();
        lever_arms.extend(self.upper_body_joints.iter().map(|joint| {
            let frame = &root_from_nodes[joint.node];
            joint.lever_arm(
                frame,
                -joint.mass,
                frame.translation * joint.mass - moments[joint.node],
            )
        }));
    }

    /// First mass moment (kg m, root frame) of each leg node with all nodes beyond it.
    pub(crate) fn leg_moments(&self, root_from_nodes: &[DAffine3]) -> [DVec3; NODES_MAX] {
        self.subtree_moments(self.upper_body_len..self.nodes.len(), root_from_nodes)
    }

    /// First mass moment (kg m, root frame) of each node of a range with the nodes of the range
    /// beyond it.
    fn subtree_moments(
        &self,
        range: std::ops::Range<usize>,
        root_from_nodes: &[DAffine3],
    ) -> [DVec3; NODES_MAX] {
        let first = range.start;
        let mut moments = [DVec3::ZERO; NODES_MAX];
        for index in range.rev() {
            let node = &self.nodes[index];
            moments[index] += root_from_nodes[index].transform_point3(node.com) * node.mass;
            if node.parent != index && node.parent >= first {
                let moment = moments[index];
                moments[node.parent] += moment;
            }
        }
        moments
    }
}

impl LoadedJoint {
    /// The lever arm of the vertical forces beyond the joint. `lift` (kg) is the supported mass
    /// less the carried mass; `arm` (kg m) is the sum of each mass times its offset from the joint.
    pub(crate) fn lever_arm(&self, root_from_node: &DAffine3, lift: f64, arm: DVec3) -> DVec3 {
        let axis = root_from_node.matrix3 * self.axis;
        match self.kind {
            JointKind::Revolute => axis.cross(arm),
            JointKind::Prismatic => axis * lift,
        }
    }
}
