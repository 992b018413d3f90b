//! Inverse dynamics of the free-floating robot by the recursive Newton-Euler algorithm
//! [Featherstone 2008, 5.3], in the root's axes: bodies that do not move against the root keep
//! their inertia there.
//!
//! The wrench on the root is what all contacts together must exert; the torques are those without
//! contacts. A contact's part of a torque is [`LinkFrames::torque_of_wrench`].

use glam::{DAffine3, DMat3, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::robot::model::{JointKind, RobotModel};

use crate::kinematics::tree::{KinematicTree, NODES_MAX, affine};

/// Number of coordinates of a velocity: root linear, root angular (both along world axes), joints.
pub const VELOCITY_MAX: usize = 6 + JOINTS_MAX;

/// The robot's bodies, compiled once.
#[derive(Debug, Clone)]
pub struct InverseDynamics {
    tree: KinematicTree,
    bodies: Vec<DynamicNode>,
}

/// A node of the kinematic tree with its inertia.
#[derive(Debug, Clone)]
struct DynamicNode {
    parent: usize,
    joint: Option<NodeJoint>,
    mass: f64,
    /// Centre of mass in the node's frame, m.
    com: DVec3,
    /// Rotational inertia about the centre of mass in the node's axes, kg m2.
    inertia: DMat3,
}

#[derive(Debug, Clone, Copy)]
struct NodeJoint {
    /// Index into `q`.
    index: usize,
    kind: JointKind,
    /// Unit axis in the node's frame.
    axis: DVec3,
}

/// The bodies at one configuration. Of the next configuration of the same robot, only those beyond
/// a joint that has moved are placed anew.
#[derive(Debug, Clone, Default)]
pub struct LinkFrames {
    q: BoundedVec<f64, JOINTS_MAX>,
    /// Frames of all bodies in the root's frame, at the positions `q`.
    root_from_nodes: BoundedVec<DAffine3, NODES_MAX>,
    bodies: BoundedVec<PlacedBody, NODES_MAX>,
    /// Frames in the world of the root and of the bodies that a leg moves.
    world_from_nodes: BoundedVec<DAffine3, NODES_MAX>,
    /// By joint of a leg: axis in the world, origin in the world (m), kind.
    joints: BoundedVec<(DVec3, DVec3, JointKind), JOINTS_MAX>,
}

/// A body at its place, in the root's axes.
#[derive(Debug, Clone, Copy, Default)]
struct PlacedBody {
    /// Its origin from its parent's, m.
    arm: DVec3,
    /// Axis of its joint.
    axis: DVec3,
    /// Centre of mass from its origin, m.
    com: DVec3,
    /// Rotational inertia about the centre of mass, kg m2.
    inertia: DMat3,
}

/// Linear acceleration with gravity, angular velocity and angular acceleration of a body.
#[derive(Debug, Clone, Copy, Default)]
struct NodeMotion {
    linear: DVec3,
    velocity: DVec3,
    angular: DVec3,
}

/// The wrench on the root and the joints' torques of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralizedForce {
    /// Force on the robot, N.
    pub force: DVec3,
    /// Moment about the root's origin, N m.
    pub moment: DVec3,
    /// Torques (N m) or forces (N) in joint order.
    pub torques: [f64; JOINTS_MAX],
}

impl Default for GeneralizedForce {
    /// No effort.
    fn default() -> Self {
        Self { force: DVec3::ZERO, moment: DVec3::ZERO, torques: [0.0; JOINTS_MAX] }
    }
}

impl LinkFrames {
    /// Frame of the root, or of a node of the kinematic tree that a leg moves.
    pub fn world_from_node(&self, node: usize) -> &DAffine3 {
        &self.world_from_nodes[node]
    }

    /// The torque (N m) or force (N) that a joint of a leg must give less if a wrench with this
    /// force (N) and this moment (N m) about `point` (world, m) acts on a body beyond it.
    pub fn torque_of_wrench(&self, joint: usize, force: DVec3, moment: DVec3, point: DVec3) -> f64 {
        let (axis, origin, kind) = &self.joints[joint];
        match kind {
            JointKind::Revolute => axis.dot(moment + (point - origin).cross(force)),
            JointKind::Prismatic => axis.dot(force),
        }
    }

    /// The velocity of a point (world, m) that is fixed to the body beyond all of `chain`, for the
    /// velocities `v` of root and joints, m/s.
    pub fn point_velocity(&self, chain: &[usize], point: DVec3, v: &[f64; VELOCITY_MAX]) -> DVec3 {
        let arm = point - self.world_from_nodes[0].translation;
        let mut velocity = DVec3::from_slice(v) + DVec3::from_slice(&v[3..]).cross(arm);
        for &index in chain {
            let (axis, origin, kind) = &self.joints[index];
            velocity += v[6 + index]
                * match kind {
                    JointKind::Revolute => axis.cross(point - origin),
                    JointKind::Prismatic => *axis,
                };
        }
        velocity
    }

    /// The angular velocity (rad/s) of the body beyond all of `chain`.
    pub fn angular_velocity(&self, chain: &[usize], v: &[f64; VELOCITY_MAX]) -> DVec3 {
        let turns = chain.iter().map(|&index| match &self.joints[index] {
            (axis, _, JointKind::Revolute) => *axis * v[6 + index],
            (_, _, JointKind::Prismatic) => DVec3::ZERO,
        });
        turns.fold(DVec3::from_slice(&v[3..]), |sum, turn| sum + turn)
    }
}

impl InverseDynamics {
    /// Compiles a robot.
    pub fn new(model: &RobotModel) -> Self {
        let tree = KinematicTree::new(model);
        let body = |(index, node): (usize, &crate::kinematics::tree::KinematicNode)| DynamicNode {
            parent: node.parent,
            joint: node.joint.map(|joint| NodeJoint {
                index: joint,
                kind: model.joints[joint].kind,
                axis: model.joints[joint].axis,
            }),
            mass: node.mass,
            com: node.com,
            inertia: node_inertia(model, &tree, index, node.com),
        };
        let bodies = tree.nodes().iter().enumerate().map(body).collect();
        Self { bodies, tree }
    }

    /// The kinematic tree, whose nodes are the bodies.
    pub fn tree(&self) -> &KinematicTree {
        &self.tree
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass).sum()
    }

    /// Places the bodies at a configuration. `frames` are new, or of the same robot.
    pub fn place(&self, root: &Pose, q: &[f64; JOINTS_MAX], frames: &mut LinkFrames) {
        self.place_in_root(q, frames);
        let world_from_root = affine(root);
        frames.world_from_nodes[0] = world_from_root;
        for index in self.tree.upper_body_len()..self.bodies.len() {
            let frame = world_from_root * frames.root_from_nodes[index];
            frames.world_from_nodes[index] = frame;
            if let Some(joint) = &self.bodies[index].joint {
                frames.joints[joint.index] =
                    (frame.matrix3 * joint.axis, frame.translation, joint.kind);
            }
        }
    }

    /// Places the bodies in the root's frame: those beyond a joint that has moved.
    fn place_in_root(&self, q: &[f64; JOINTS_MAX], frames: &mut LinkFrames) {
        let is_new = frames.q.is_empty();
        if is_new {
            let count = self.bodies.len();
            let _fits = frames.world_from_nodes.resize(count, DAffine3::IDENTITY);
            let _fits = frames.root_from_nodes.resize(count, DAffine3::IDENTITY);
            let _fits = frames.bodies.resize(count, PlacedBody::default());
            let unused = (DVec3::ZERO, DVec3::ZERO, JointKind::Revolute);
            let _fits = frames.joints.resize(JOINTS_MAX, unused);
            let _fits = frames.q.resize(JOINTS_MAX, 0.0);
        }
        let mut has_moved = [is_new; NODES_MAX];
        for (index, body) in self.bodies.iter().enumerate() {
            if let Some(joint) = &body.joint {
                let has_turned = q[joint.index].to_bits() != frames.q[joint.index].to_bits();
                has_moved[index] |= has_moved[body.parent] || has_turned;
            }
            if has_moved[index] {
                self.tree.place(index..index + 1, q, &mut frames.root_from_nodes);
                let root_from_parent = &frames.root_from_nodes[body.parent];
                frames.bodies[index] =
                    body.placed(root_from_parent, &frames.root_from_nodes[index]);
            }
        }
        frames.q.copy_from_slice(q);
    }

    /// Wrench and torques of a motion: velocities `v` and accelerations `a` of root (along world
    /// axes) and joints, and `gravity` (m/s2, downward).
    pub fn effort(
        &self,
        frames: &LinkFrames,
        v: &[f64; VELOCITY_MAX],
        a: &[f64; VELOCITY_MAX],
        gravity: f64,
    ) -> GeneralizedForce {
        let world_from_root = frames.world_from_nodes[0].matrix3;
        let into_root = world_from_root.transpose();
        let of_root = NodeMotion {
            linear: into_root * (DVec3::from_slice(a) + DVec3::Z * gravity),
            velocity: into_root * DVec3::from_slice(&v[3..]),
            angular: into_root * DVec3::from_slice(&a[3..]),
        };
        let mut forces = self.forward(frames, of_root, v, a);
        let mut torques = [0.0; JOINTS_MAX];
        for index in (1..self.bodies.len()).rev() {
            let (body, placed) = (&self.bodies[index], &frames.bodies[index]);
            let (force, moment) = forces[index];
            if let Some(joint) = &body.joint {
                torques[joint.index] = match joint.kind {
                    JointKind::Revolute => placed.axis.dot(moment),
                    JointKind::Prismatic => placed.axis.dot(force),
                };
            }
            let parent = &mut forces[body.parent];
            parent.0 += force;
            parent.1 += moment + placed.arm.cross(force);
        }
        let (force, moment) = forces[0];
        GeneralizedForce {
            force: world_from_root * force,
            moment: world_from_root * moment,
            torques,
        }
    }

    /// Force on every body, and moment about its origin, in the root's axes.
    fn forward(
        &self,
        frames: &LinkFrames,
        of_root: NodeMotion,
        v: &[f64; VELOCITY_MAX],
        a: &[f64; VELOCITY_MAX],
    ) -> BoundedVec<(DVec3, DVec3), NODES_MAX> {
        let mut motions = BoundedVec::<NodeMotion, NODES_MAX>::new();
        let mut forces = BoundedVec::new();
        for (body, placed) in self.bodies.iter().zip(&frames.bodies) {
            let motion = match &body.joint {
                None => of_root,
                Some(joint) => {
                    let rates = (v[6 + joint.index], a[6 + joint.index]);
                    motions[body.parent].beyond(joint.kind, placed, rates)
                }
            };
            let _fits = (motions.push(motion), forces.push(placed.force(body.mass, &motion)));
        }
        forces
    }
}

impl NodeMotion {
    /// The motion of a body beyond a joint of this one, at these joint velocity and acceleration.
    fn beyond(&self, kind: JointKind, body: &PlacedBody, (dq, ddq): (f64, f64)) -> Self {
        let PlacedBody { arm, axis, .. } = *body;
        let spin = self.velocity.cross(self.velocity.cross(arm));
        let linear = self.linear + self.angular.cross(arm) + spin;
        match kind {
            JointKind::Revolute => Self {
                linear,
                velocity: self.velocity + axis * dq,
                angular: self.angular + axis * ddq + self.velocity.cross(axis * dq),
            },
            JointKind::Prismatic => {
                Self { linear: linear + axis * ddq + 2.0 * self.velocity.cross(axis * dq), ..*self }
            }
        }
    }
}

impl DynamicNode {
    /// The body at a place.
    fn placed(&self, root_from_parent: &DAffine3, root_from_node: &DAffine3) -> PlacedBody {
        let rotation = root_from_node.matrix3;
        PlacedBody {
            arm: root_from_node.translation - root_from_parent.translation,
            axis: self.joint.as_ref().map_or(DVec3::ZERO, |joint| rotation * joint.axis),
            com: rotation * self.com,
            inertia: rotation * self.inertia * rotation.transpose(),
        }
    }
}

impl PlacedBody {
    /// Force on the body, and moment about its origin.
    fn force(&self, mass: f64, motion: &NodeMotion) -> (DVec3, DVec3) {
        let NodeMotion { linear, velocity, angular } = *motion;
        let spin = velocity.cross(velocity.cross(self.com));
        let force = (linear + angular.cross(self.com) + spin) * mass;
        let moment = self.inertia * angular + velocity.cross(self.inertia * velocity);
        (force, moment + self.com.cross(force))
    }
}

/// Rotational inertia of all links of a node about the node's centre of mass.
fn node_inertia(model: &RobotModel, tree: &KinematicTree, node: usize, com: DVec3) -> DMat3 {
    let mut inertia = DMat3::ZERO;
    for (index, link) in model.links.iter().enumerate() {
        let (of, node_from_link) = tree.of_link(index);
        if of == node {
            let rotation = DMat3::from_quat(node_from_link.rotation);
            let offset = node_from_link * link.com - com;
            let outer = DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
            let steiner = DMat3::from_diagonal(DVec3::splat(offset.length_squared())) - outer;
            inertia += rotation * link.inertia * rotation.transpose() + steiner * link.mass;
        }
    }
    inertia
}
