//! Gravity torques of a robot at rest. Contact forces are taken as vertical, which the inclination
//! bound of foot placements keeps inside the friction cone.

use glam::{DAffine3, DVec2, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::robot::model::{JointIndex, JointKind, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::KinematicTree;
use crate::kinematics::tree::NODES_MAX;
use crate::robot::kinematic_state::KinematicState;

/// The robot's mass tree, compiled for gravity torques.
#[derive(Debug, Clone)]
pub struct Statics {
    nodes: Vec<MassNode>,
    upper_body_len: usize,
    /// The joints of the upper-body nodes, whose torques the feet's loads do not change.
    upper_body_joints: Vec<StaticJoint>,
    /// The others.
    leg_joints: Vec<StaticJoint>,
    mass: f64,
}

#[derive(Debug, Clone)]
struct MassNode {
    parent: usize,
    mass: f64,
    com: DVec3,
}

#[derive(Debug, Clone)]
struct StaticJoint {
    joint: usize,
    node: usize,
    axis: DVec3,
    kind: JointKind,
    /// The mass that it carries, kg.
    mass: f64,
    effort: f64,
    carries: [bool; 2],
}

/// What each upper-body joint does against gravity: its torque or force is `-gravity` times the
/// lever along the vertical. In the root's frame; kg m or kg.
pub type LeverArms = heapless::Vec<DVec3, JOINTS_MAX>;

/// A vertical force on a foot: the share of the weight, and where it acts in world x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootLoad {
    /// Share of the weight, 0 to 1.
    pub share: f64,
    /// Centre of pressure in world x and y, m.
    pub point: DVec2,
}

impl FootLoad {
    /// The whole weight on one foot, left and right.
    pub fn all_on(limb: usize, point: DVec2) -> [Self; 2] {
        [0, 1].map(|foot| Self { share: if foot == limb { 1.0 } else { 0.0 }, point })
    }
}

impl Statics {
    /// Compiles a robot; only `effort_share` of each joint's effort may be used.
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
        let static_joint = |(node, joint): (usize, usize)| StaticJoint {
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
            .map(static_joint)
            .partition(|joint: &StaticJoint| joint.node < tree.upper_body_len());
        Self {
            nodes,
            upper_body_len: tree.upper_body_len(),
            upper_body_joints,
            leg_joints,
            mass: masses[0],
        }
    }

    /// The robot's mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// The torque (N m) or force (N) of a joint that may be used.
    pub fn usable_effort(&self, joint: JointIndex) -> f64 {
        self.joint(joint).map_or(0.0, |joint| joint.effort)
    }

    /// The mass that hangs on a joint, seen from the root, kg.
    pub fn carried_mass(&self, joint: JointIndex) -> f64 {
        self.joint(joint).map_or(0.0, |joint| joint.mass)
    }

    fn joint(&self, index: JointIndex) -> Option<&StaticJoint> {
        self.upper_body_joints.iter().chain(&self.leg_joints).find(|joint| joint.joint == index)
    }

    /// The levers of the upper-body joints where the upper-body nodes are placed so in the root's
    /// frame.
    pub fn update_lever_arms(&self, root_from_nodes: &[DAffine3], lever_arms: &mut LeverArms) {
        let moments = self.subtree_moments(0, self.upper_body_len, root_from_nodes);
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

    /// By how much the centre of mass moves in the world when a upper-body joint does, m for each
    /// rad or m of it.
    pub fn com_shift(&self, kinematic_state: &KinematicState, joint: JointIndex) -> DVec3 {
        let lever_arm = self
            .upper_body_joints
            .iter()
            .zip(kinematic_state.lever_arms())
            .find(|(candidate, _)| candidate.joint == joint)
            .map_or(DVec3::ZERO, |(_, lever_arm)| *lever_arm);
        *kinematic_state.world_rotation() * (-lever_arm / self.mass)
    }

    /// The largest share of a joint's usable effort that gravity asks for when the feet carry
    /// `loads`.
    pub fn effort_use(&self, kinematic_state: &KinematicState, loads: &[FootLoad; 2]) -> f64 {
        let mut most: f64 = 0.0;
        self.for_each_torque(kinematic_state, loads, |joint, torque| {
            most = most.max(torque.abs() / joint.effort)
        });
        most
    }

    /// The joint of which gravity asks the largest share of its usable effort then, and that share,
    /// if it asks anything of any.
    pub fn most_strained(
        &self,
        kinematic_state: &KinematicState,
        loads: &[FootLoad; 2],
    ) -> Option<(JointIndex, f64)> {
        let mut most: Option<(JointIndex, f64)> = None;
        self.for_each_torque(kinematic_state, loads, |joint, torque| {
            let share = torque.abs() / joint.effort;
            if share > most.map_or(0.0, |(_, most)| most) {
                most = Some((joint.joint, share));
            }
        });
        most
    }

    /// The torque (N m) or force (N) that each joint must hold, in joint order.
    pub fn torques(
        &self,
        kinematic_state: &KinematicState,
        loads: &[FootLoad; 2],
        torques: &mut [f64; JOINTS_MAX],
    ) {
        self.for_each_torque(kinematic_state, loads, |joint, torque| torques[joint.joint] = torque);
    }

    fn for_each_torque(
        &self,
        kinematic_state: &KinematicState,
        loads: &[FootLoad; 2],
        mut visit: impl FnMut(&StaticJoint, f64),
    ) {
        let down = kinematic_state.turned_to_root(DVec3::NEG_Z * GRAVITY);
        for (joint, lever_arm) in self.upper_body_joints.iter().zip(kinematic_state.lever_arms()) {
            visit(joint, down.dot(*lever_arm));
        }
        let frames = kinematic_state.root_from_nodes();
        let moments = self.subtree_moments(self.upper_body_len, self.nodes.len(), frames);
        // Where each load acts, at whatever height: all forces are vertical.
        let pressed = loads.map(|load| {
            let point = kinematic_state.turned_to_root(
                load.point.extend(0.0) - kinematic_state.world_from_root.translation,
            );
            (point, self.mass * load.share)
        });
        for joint in &self.leg_joints {
            let frame = &frames[joint.node];
            let mut lift = -joint.mass;
            let mut arm = frame.translation * joint.mass - moments[joint.node];
            for ((point, mass), _) in
                pressed.iter().zip(joint.carries).filter(|(_, carries)| *carries)
            {
                lift += mass;
                arm += (*point - frame.translation) * *mass;
            }
            visit(joint, down.dot(joint.lever_arm(frame, lift, arm)));
        }
    }

    /// The first mass moment (kg m) of each node of a range and what hangs on it, in the root's
    /// frame.
    fn subtree_moments(
        &self,
        first: usize,
        end: usize,
        root_from_nodes: &[DAffine3],
    ) -> [DVec3; NODES_MAX] {
        let mut moments = [DVec3::ZERO; NODES_MAX];
        for index in (first..end).rev() {
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

impl StaticJoint {
    /// Its lever, where `lift` is the mass that pushes up beyond it less what it carries, and `arm`
    /// the sum of each times where it acts from the joint.
    fn lever_arm(&self, root_from_node: &DAffine3, lift: f64, arm: DVec3) -> DVec3 {
        let axis = root_from_node.matrix3 * self.axis;
        match self.kind {
            JointKind::Revolute => axis.cross(arm),
            JointKind::Prismatic => axis * lift,
        }
    }
}

/// Vertical loads on both feet that balance a centre of mass at `com` with `share` of the weight on
/// foot 1, each within its own support polygon; `None` where this share admits none.
pub fn balance_loads(regions: [&ConvexRegion; 2], com: DVec2, share: f64) -> Option<[FootLoad; 2]> {
    let shares = [1.0 - share, share];
    let mut points = regions.map(ConvexRegion::centroid);
    for _ in 0..BALANCE_ITERATIONS {
        for foot in 0..2 {
            let other = 1 - foot;
            if shares[foot] > 1e-6 {
                points[foot] =
                    regions[foot].nearest((com - points[other] * shares[other]) / shares[foot]);
            }
        }
        let balanced = points[0] * shares[0] + points[1] * shares[1];
        if balanced.distance(com) < BALANCE_TOLERANCE {
            return Some([0, 1].map(|foot| FootLoad { share: shares[foot], point: points[foot] }));
        }
    }
    None
}

/// Alternating projections between the two support polygons.
const BALANCE_ITERATIONS: usize = 12;
/// Largest error of the balanced centre of mass, m.
const BALANCE_TOLERANCE: f64 = 1e-6;
