//! What follows from a configuration: where every part of the robot is. Kept in the root's frame,
//! so that what the legs do not move is worked out only when it changes.

use glam::{DAffine3, DMat3, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::kinematics::tree::{NODES_MAX, affine, pose};
use crate::robot::bounding_spheres::Centers;
use crate::robot::gravity_torques::LeverArms;
use crate::robot::mechanism::{Configuration, Mechanism};

/// A configuration's consequences.
#[derive(Debug, Clone, Default)]
pub struct KinematicState {
    /// The root's pose.
    pub world_from_root: Pose,
    /// The centre of mass in the world, m.
    pub com: DVec3,
    world_rotation: DMat3,
    root_from_nodes: BoundedVec<DAffine3, NODES_MAX>,
    centers: Centers,
    upper_body: UpperBodyState,
}

/// What follows from the joints of the upper-body nodes alone.
#[derive(Debug, Clone)]
struct UpperBodyState {
    /// The joint positions that it was worked out for; others are not looked at.
    q: [f64; JOINTS_MAX],
    /// First mass moment in the root's frame, kg m.
    moment: DVec3,
    lever_arms: LeverArms,
}

impl Default for UpperBodyState {
    fn default() -> Self {
        Self { q: [f64::NAN; JOINTS_MAX], moment: DVec3::ZERO, lever_arms: LeverArms::default() }
    }
}

impl KinematicState {
    /// The kinematic state of a robot whose links have these poses, one for each; they need not fit
    /// together.
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

    /// Becomes the kinematic state of a configuration.
    pub(crate) fn update(&mut self, robot: &Mechanism, configuration: &Configuration) {
        let tree = &robot.tree;
        let q = &configuration.q;
        // Never a number before the first time.
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
        robot.statics.update_lever_arms(&self.root_from_nodes, &mut self.upper_body.lever_arms);
        self.centers.place_upper_body(
            &robot.spheres,
            robot.tree.upper_body_len(),
            &self.root_from_nodes,
        );
    }

    fn finish(&mut self, robot: &Mechanism) {
        let legs = robot.tree.upper_body_len()..robot.tree.nodes().len();
        let moment = self.upper_body.moment + robot.tree.moment(legs, &self.root_from_nodes);
        self.com = self.to_world(moment / robot.statics.mass());
        self.centers.place_legs(&robot.spheres, robot.tree.upper_body_len(), &self.root_from_nodes);
    }

    /// Every node's frame in the root's.
    pub fn root_from_nodes(&self) -> &[DAffine3] {
        &self.root_from_nodes
    }

    /// The middles of the balls around what may collide, in the root's frame.
    pub fn centers(&self) -> &Centers {
        &self.centers
    }

    /// The levers of the upper-body joints.
    pub fn lever_arms(&self) -> &LeverArms {
        &self.upper_body.lever_arms
    }

    /// The root's rotation in the world.
    pub fn world_rotation(&self) -> &DMat3 {
        &self.world_rotation
    }

    /// A node's pose in the world.
    pub fn world_from_node(&self, node: usize) -> Pose {
        self.world_from_root * pose(&self.root_from_nodes[node])
    }

    /// A point of the root's frame in the world.
    pub fn to_world(&self, point: DVec3) -> DVec3 {
        self.world_rotation * point + self.world_from_root.translation
    }

    /// A vector of the world in the root's frame.
    pub fn turned_to_root(&self, vector: DVec3) -> DVec3 {
        let r = &self.world_rotation;
        DVec3::new(r.x_axis.dot(vector), r.y_axis.dot(vector), r.z_axis.dot(vector))
    }
}
