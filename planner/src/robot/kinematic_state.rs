//! Link frames and centre of mass of one configuration.
//!
//! Frames are kept in the root frame, so that the upper-body nodes are computed anew only when one
//! of their joints moves.

use glam::{DAffine3, DMat3, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::kinematics::tree::{NODES_MAX, affine, pose};
use crate::robot::bounding_spheres::Centers;
use crate::robot::configuration::Configuration;
use crate::robot::mass_tree::LeverArms;
use crate::robot::mechanism::Mechanism;

/// The link frames and the centre of mass of one configuration.
#[derive(Debug, Clone, Default)]
pub struct KinematicState {
    /// Pose of the root in the world.
    pub world_from_root: Pose,
    /// Centre of mass in the world, m.
    pub com: DVec3,
    world_rotation: DMat3,
    root_from_nodes: BoundedVec<DAffine3, NODES_MAX>,
    centers: Centers,
    upper_body: UpperBodyState,
}

/// The values that depend on the upper-body joints alone.
#[derive(Debug, Clone)]
struct UpperBodyState {
    /// Joint positions of the last update; only those of upper-body joints are compared.
    q: [f64; JOINTS_MAX],
    /// First mass moment in the root frame, kg m.
    moment: DVec3,
    lever_arms: LeverArms,
}

impl Default for UpperBodyState {
    fn default() -> Self {
        Self { q: [f64::NAN; JOINTS_MAX], moment: DVec3::ZERO, lever_arms: LeverArms::default() }
    }
}

impl KinematicState {
    /// The kinematic state of a configuration.
    pub fn new(robot: &Mechanism, configuration: &Configuration) -> Self {
        let mut kinematic_state = Self::default();
        kinematic_state.update(robot, configuration);
        kinematic_state
    }

    /// The kinematic state of a robot whose links have the given world poses, one per link. The
    /// poses need not be consistent with the joints.
    pub fn from_link_poses(robot: &Mechanism, world_from_links: &[Pose]) -> Self {
        let mut kinematic_state = Self { world_rotation: DMat3::IDENTITY, ..Self::default() };
        let _ = kinematic_state
            .root_from_nodes
            .extend_from_slice(&[DAffine3::IDENTITY; NODES_MAX][..robot.tree.nodes().len()]);
        for (node, frame) in robot.tree.nodes().iter().zip(&mut kinematic_state.root_from_nodes) {
            *frame = affine(&world_from_links[node.link]);
        }
        kinematic_state.finish_upper_body(robot);
        kinematic_state.finish(robot);
        kinematic_state
    }

    /// Overwrites this state with that of another configuration of the same robot. The upper-body
    /// nodes are kept where none of their joints has moved.
    pub fn update(&mut self, robot: &Mechanism, configuration: &Configuration) {
        let tree = &robot.tree;
        let q = &configuration.q;
        // The initial positions are NaN and compare unequal, so the first update computes all.
        if tree.upper_body_joints().any(|joint| q[joint] != self.upper_body.q[joint])
            || self.root_from_nodes.is_empty()
        {
            let _ = self.root_from_nodes.resize(tree.nodes().len(), DAffine3::IDENTITY);
            tree.place(0..tree.upper_body_len(), q, &mut self.root_from_nodes);
            self.finish_upper_body(robot);
            self.upper_body.q = *q;
        }
        tree.place(tree.upper_body_len()..tree.nodes().len(), q, &mut self.root_from_nodes);
        self.world_from_root = configuration.world_from_root;
        self.world_rotation = DMat3::from_quat(configuration.world_from_root.rotation);
        self.finish(robot);
    }

    fn finish_upper_body(&mut self, robot: &Mechanism) {
        self.upper_body.moment =
            robot.tree.moment(0..robot.tree.upper_body_len(), &self.root_from_nodes);
        robot.mass_tree.update_lever_arms(&self.root_from_nodes, &mut self.upper_body.lever_arms);
        self.centers.place_upper_body(
            &robot.spheres,
            robot.tree.upper_body_len(),
            &self.root_from_nodes,
        );
    }

    fn finish(&mut self, robot: &Mechanism) {
        let legs = robot.tree.upper_body_len()..robot.tree.nodes().len();
        let moment = self.upper_body.moment + robot.tree.moment(legs, &self.root_from_nodes);
        self.com = self.to_world(moment / robot.mass_tree.mass());
        self.centers.place_legs(&robot.spheres, robot.tree.upper_body_len(), &self.root_from_nodes);
    }

    /// Frame of every node in the root frame.
    pub(crate) fn root_from_nodes(&self) -> &[DAffine3] {
        &self.root_from_nodes
    }

    /// Centres of the bounding spheres in the root frame.
    pub(crate) fn centers(&self) -> &Centers {
        &self.centers
    }

    /// Lever arms of the upper-body joints.
    pub(crate) fn lever_arms(&self) -> &LeverArms {
        &self.upper_body.lever_arms
    }

    /// Rotation of the root in the world.
    pub(crate) fn world_rotation(&self) -> &DMat3 {
        &self.world_rotation
    }

    /// Pose of a node in the world.
    pub fn world_from_node(&self, node: usize) -> Pose {
        self.world_from_root * pose(&self.root_from_nodes[node])
    }

    /// Pose of a link in the world.
    pub fn world_from_link(&self, robot: &Mechanism, link: usize) -> Pose {
        let (node, node_from_link) = robot.tree.of_link(link);
        self.world_from_node(node) * node_from_link
    }

    /// Pose of a sole in the world.
    pub fn world_from_sole(&self, robot: &Mechanism, limb: usize) -> Pose {
        let sole = &robot.soles[limb];
        self.world_from_link(robot, sole.link) * sole.link_from_sole
    }

    /// World coordinates of a point of the root frame.
    pub(crate) fn to_world(&self, point: DVec3) -> DVec3 {
        self.world_rotation * point + self.world_from_root.translation
    }

    /// Root-frame coordinates of a vector of the world.
    pub(crate) fn turned_to_root(&self, vector: DVec3) -> DVec3 {
        let r = &self.world_rotation;
        DVec3::new(r.x_axis.dot(vector), r.y_axis.dot(vector), r.z_axis.dot(vector))
    }
}
