//! What follows from a configuration: where every part of the robot is. Kept in the root's frame,
//! so that what the legs do not move is worked out only when it changes.

use glam::{DAffine3, DMat3, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;

use crate::body::{Body, Configuration};
use crate::collision::ball::Centers;
use crate::kinematics::tree::{NODES_MAX, affine, pose};
use crate::statics::Levers;

/// A configuration's consequences.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// The root's pose.
    pub world_from_root: Pose,
    /// The centre of mass in the world, m.
    pub com: DVec3,
    world_rotation: DMat3,
    root_from_nodes: BoundedVec<DAffine3, NODES_MAX>,
    centers: Centers,
    held: Held,
}

/// What follows from the joints of the held nodes alone.
#[derive(Debug, Clone)]
struct Held {
    /// The joint positions that it was worked out for; others are not looked at.
    q: [f64; JOINTS_MAX],
    /// First mass moment in the root's frame, kg m.
    moment: DVec3,
    levers: Levers,
}

impl Default for Held {
    fn default() -> Self {
        Self { q: [f64::NAN; JOINTS_MAX], moment: DVec3::ZERO, levers: Levers::default() }
    }
}

impl Snapshot {
    /// The snapshot of a robot whose links have these poses, one for each; they need not fit
    /// together.
    pub fn of_links(body: &Body, world_from_links: &[Pose]) -> Self {
        let mut snapshot = Self { world_rotation: DMat3::IDENTITY, ..Self::default() };
        let _ = snapshot
            .root_from_nodes
            .extend_from_slice(&[DAffine3::IDENTITY; NODES_MAX][..body.tree.nodes().len()]);
        for (node, frame) in body.tree.nodes().iter().zip(&mut snapshot.root_from_nodes) {
            *frame = affine(&world_from_links[node.link]);
        }
        snapshot.finish_held(body);
        snapshot.finish(body);
        snapshot
    }

    /// Becomes the snapshot of a configuration.
    pub(crate) fn take(&mut self, body: &Body, configuration: &Configuration) {
        let tree = &body.tree;
        let q = &configuration.q;
        // Never a number before the first time.
        if tree.held_joints().any(|joint| q[joint] != self.held.q[joint])
            || self.root_from_nodes.is_empty()
        {
            let _ = self.root_from_nodes.resize(tree.nodes().len(), DAffine3::IDENTITY);
            tree.place(0..tree.held_len(), q, &mut self.root_from_nodes);
            self.finish_held(body);
            self.held.q = *q;
        }
        tree.place(tree.held_len()..tree.nodes().len(), q, &mut self.root_from_nodes);
        self.world_from_root = configuration.world_from_root;
        self.world_rotation = DMat3::from_quat(configuration.world_from_root.rotation);
        self.finish(body);
    }

    fn finish_held(&mut self, body: &Body) {
        self.held.moment = body.tree.moment(0..body.tree.held_len(), &self.root_from_nodes);
        body.statics.hold(&self.root_from_nodes, &mut self.held.levers);
        self.centers.place_held(&body.balls, body.tree.held_len(), &self.root_from_nodes);
    }

    fn finish(&mut self, body: &Body) {
        let moving = body.tree.held_len()..body.tree.nodes().len();
        let moment = self.held.moment + body.tree.moment(moving, &self.root_from_nodes);
        self.com = self.to_world(moment / body.statics.mass());
        self.centers.place_moving(&body.balls, body.tree.held_len(), &self.root_from_nodes);
    }

    /// Every node's frame in the root's.
    pub fn root_from_nodes(&self) -> &[DAffine3] {
        &self.root_from_nodes
    }

    /// The middles of the balls around what may collide, in the root's frame.
    pub fn centers(&self) -> &Centers {
        &self.centers
    }

    /// The levers of the held joints.
    pub fn levers(&self) -> &Levers {
        &self.held.levers
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
