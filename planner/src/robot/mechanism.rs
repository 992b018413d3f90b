//! The robot, compiled once into what the search asks of it all the time.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::leg::{LegError, limits_within};
use crate::kinematics::{KinematicTree, Leg};
use crate::robot::ankle_limits::AnkleLimits;
use crate::robot::bounding_spheres::{BodySphere, body_spheres};
use crate::robot::gravity_torques::Statics;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::single_support::SingleSupportPosture;

/// Most links of a robot, fixed ones included.
pub const LINKS_MAX: usize = 192;

/// A whole-body configuration: where the root is and how the joints stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Configuration {
    /// The root's pose in the world.
    pub world_from_root: Pose,
    /// Joint positions in the order of `RobotModel::joints`, the rest 0.
    pub q: [f64; JOINTS_MAX],
}

/// A robot that cannot be planned for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MechanismError {
    /// A leg that cannot place its sole freely.
    #[error(transparent)]
    Leg(#[from] LegError),
    /// More links than [`LINKS_MAX`].
    #[error("the robot has {links} links; at most {LINKS_MAX} are supported: merge fixed ones")]
    TooManyLinks {
        /// How many it has.
        links: usize,
    },
    /// Not a biped.
    #[error("the robot has {feet} feet; the planner walks on exactly 2")]
    FeetCount {
        /// How many it has.
        feet: usize,
    },
}

/// What a finger or a gripper carries at the most, as a share of the robot's mass: wrists of
/// humanoids carry from 0.18 % on.
const FINGER_SHARE_MAX: f64 = 1.6e-3;
/// A joint on which this share of the robot's mass hangs carries its trunk.
const TRUNK_SHARE: f64 = 0.2;
/// Joints that carry the trunk at most.
pub const TRUNK_JOINTS_MAX: usize = 4;

/// The compiled robot. Constant during a search.
#[derive(Debug, Clone)]
pub struct Mechanism {
    /// Forward kinematics.
    pub tree: KinematicTree,
    /// Bounding spheres around what may collide.
    pub spheres: Vec<BodySphere>,
    /// The legs, by limb.
    pub legs: [Leg; 2],
    /// Gravity torques.
    pub statics: Statics,
    /// The link of each foot.
    pub foot_links: [usize; 2],
    /// Each sole's frame in its foot link's.
    pub links_from_soles: [Pose; 2],
    /// Each sole's outline in its own frame.
    pub sole_polygons: [Vec<DVec2>; 2],
    /// Where each sole can carry the robot's weight for its ankle.
    pub ankle_limits: [AnkleLimits; 2],
    /// How the robot carries itself on each foot.
    pub single_support_postures: [SingleSupportPosture; 2],
    /// The standing posture's joint positions.
    pub standing_q: [f64; JOINTS_MAX],
    /// Where the centre of mass is then, in the root's frame, m.
    pub standing_com: DVec3,
    /// How much of each leg's reach the standing posture uses, 0 to 1, the larger of the two.
    pub standing_leg_extension: f64,
    /// The joints that are free in every mode: all that carry no foot, with their limits.
    pub free_joints: Vec<FreeJoint>,
    /// Those of them that carry the trunk, seen from the root.
    pub trunk_joints: Vec<FreeJoint>,
    /// Joints in use.
    pub joints_len: usize,
}

/// A joint that carries no foot.
#[derive(Debug, Clone, Copy)]
pub struct FreeJoint {
    /// Index into `q`.
    pub index: usize,
    /// Lower limit with the planner's margin.
    pub lower: f64,
    /// Upper limit with the planner's margin.
    pub upper: f64,
    /// Whether samples move it. Fingers neither balance the robot nor make room for it, and stay as
    /// they are.
    pub is_sampled: bool,
}

impl Mechanism {
    /// Compiles a robot.
    ///
    /// # Errors
    /// The robot is no biped that this planner can move; the message says why.
    pub fn new(model: &RobotModel, config: &PlannerConfig) -> Result<Self, MechanismError> {
        let [left, right] = model.feet.as_slice() else {
            return Err(MechanismError::FeetCount { feet: model.feet.len() });
        };
        if model.links.len() > LINKS_MAX {
            return Err(MechanismError::TooManyLinks { links: model.links.len() });
        }
        let margin = config.joint_margin;
        let legs = [Leg::new(model, 0, margin)?, Leg::new(model, 1, margin)?];
        let mut standing_q = [0.0; JOINTS_MAX];
        standing_q[..model.joints.len()].copy_from_slice(&model.standing_q);
        let standing_leg_extension =
            legs.iter().map(|leg| leg_extension(leg, &standing_q)).fold(0.0, f64::max);
        let statics = Statics::new(model, config.effort_share);
        let free_joints = free_joints(model, margin, &statics);
        let ankle =
            |limb: usize| AnkleLimits::new(&legs[limb], &standing_q, &statics, config.com_margin);
        let tree = KinematicTree::new(model);
        let carries_trunk =
            |joint: &&FreeJoint| statics.carried_mass(joint.index) >= TRUNK_SHARE * statics.mass();
        let trunk_joints =
            free_joints.iter().filter(carries_trunk).take(TRUNK_JOINTS_MAX).copied().collect();
        let mut robot = Self {
            spheres: body_spheres(model, &tree),
            tree,
            ankle_limits: [ankle(0), ankle(1)],
            single_support_postures: [SingleSupportPosture::standing(standing_q); 2],
            statics,
            foot_links: [left.link, right.link],
            links_from_soles: [left.link_from_sole, right.link_from_sole],
            sole_polygons: [left.polygon.clone(), right.polygon.clone()],
            free_joints,
            trunk_joints,
            joints_len: model.joints.len(),
            legs,
            standing_q,
            standing_com: DVec3::ZERO,
            standing_leg_extension,
        };
        robot.standing_com = robot
            .kinematic_state(&Configuration { world_from_root: Pose::IDENTITY, q: standing_q })
            .com;
        robot.single_support_postures =
            [0, 1].map(|limb| SingleSupportPosture::derive(&robot, limb));
        Ok(robot)
    }

    /// What follows from a configuration.
    pub fn kinematic_state(&self, configuration: &Configuration) -> KinematicState {
        let mut kinematic_state = KinematicState::default();
        self.update_kinematic_state(configuration, &mut kinematic_state);
        kinematic_state
    }

    /// The same, over another configuration's kinematic state: what no leg moves stays where it is
    /// in the root's frame while its joints do, and nothing is copied.
    pub fn update_kinematic_state(
        &self,
        configuration: &Configuration,
        kinematic_state: &mut KinematicState,
    ) {
        kinematic_state.update(self, configuration);
    }

    /// A link's pose in the world.
    pub fn world_from_link(&self, kinematic_state: &KinematicState, link: usize) -> Pose {
        let (node, node_from_link) = self.tree.of_link(link);
        kinematic_state.world_from_node(node) * node_from_link
    }

    /// A sole's pose in the world.
    pub fn world_from_sole(&self, kinematic_state: &KinematicState, limb: usize) -> Pose {
        self.world_from_link(kinematic_state, self.foot_links[limb]) * self.links_from_soles[limb]
    }

    /// Where the ankle of a foot whose whole sole is carried can hold the weight, for a pose of the
    /// sole (world x and y).
    pub fn ankle_support_region(&self, limb: usize, world_from_sole: &Pose) -> ConvexRegion {
        ConvexRegion::seen_from_above(
            world_from_sole,
            &self.ankle_limits[limb].clip(&self.sole_polygons[limb]),
        )
    }

    /// Moves both legs so that their soles stand at these poses; `false` where a leg cannot.
    pub fn place_soles(
        &self,
        configuration: &mut Configuration,
        world_from_soles: &[Pose; 2],
    ) -> bool {
        let root_from_world = configuration.world_from_root.inverse();
        self.legs
            .iter()
            .zip(world_from_soles)
            .all(|(leg, sole)| leg.solve(&(root_from_world * *sole), &mut configuration.q))
    }

    /// The same, but only where [`Leg::solve_near`] finds a way: for samples, many of which have
    /// none.
    pub fn place_soles_near(
        &self,
        configuration: &mut Configuration,
        world_from_soles: &[Pose; 2],
    ) -> bool {
        let root_from_world = configuration.world_from_root.inverse();
        self.legs
            .iter()
            .zip(world_from_soles)
            .all(|(leg, sole)| leg.solve_near(&(root_from_world * *sole), &mut configuration.q))
    }

    /// The reach of the shorter leg, m.
    pub fn shorter_reach(&self) -> f64 {
        self.legs.iter().map(Leg::reach).fold(f64::INFINITY, f64::min)
    }

    /// The greatest root height (m) at which, seen from `root`'s place and rotation, each hip is at
    /// most its share of reach away from its ankle; `None` where a foot is too far to the side.
    pub fn root_height(
        &self,
        root: &Pose,
        world_from_soles: &[Pose; 2],
        leg_extensions: [f64; 2],
    ) -> Option<f64> {
        let mut height = f64::INFINITY;
        for ((leg, sole), share) in self.legs.iter().zip(world_from_soles).zip(leg_extensions) {
            let hip = root.rotation * leg.hip();
            let ankle = *sole * leg.sole_from_ankle();
            let aside = (ankle - root.translation - hip).truncate().length_squared();
            let length = share * leg.reach();
            let rise = length * length - aside;
            if rise <= 0.0 {
                return None;
            }
            height = height.min(ankle.z + libm::sqrt(rise) - hip.z);
        }
        Some(height)
    }
}

/// The joints that carry no foot.
fn free_joints(model: &RobotModel, margin: f64, statics: &Statics) -> Vec<FreeJoint> {
    let carry_feet: Vec<usize> =
        model.feet.iter().flat_map(|foot| model.chain(foot.link)).collect();
    let free = model.joints.iter().enumerate().filter(|(index, _)| !carry_feet.contains(index));
    let within = |(index, joint)| {
        let [lower, upper] = limits_within(joint, margin);
        let is_sampled = statics.carried_mass(index) >= FINGER_SHARE_MAX * statics.mass();
        FreeJoint { index, lower, upper, is_sampled }
    };
    free.map(within).collect()
}

fn leg_extension(leg: &Leg, q: &[f64]) -> f64 {
    let ankle = leg.root_from_sole(q) * leg.sole_from_ankle();
    ankle.distance(leg.hip()) / leg.reach()
}
