//! The robot, compiled once into the form that the search evaluates.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::kinematics::leg::{Leg, LegError};
use crate::kinematics::tree::KinematicTree;
use crate::robot::ankle_limits::AnkleLimits;
use crate::robot::bounding_spheres::{BodySphere, body_spheres};
use crate::robot::configuration::Configuration;
use crate::robot::free_joints::{FreeJoint, free_joints, trunk_joints};
use crate::robot::mass_tree::MassTree;
use crate::robot::sole::Sole;
use crate::robot::tuning::PROJECTED_LEAN_COSINE;

/// Most links of a robot, fixed ones included.
pub const LINKS_MAX: usize = 192;

/// Why a robot cannot be planned for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MechanismError {
    /// A leg cannot place its sole freely.
    #[error(transparent)]
    Leg(#[from] LegError),
    /// The robot has more than [`LINKS_MAX`] links.
    #[error("the robot has {links} links; at most {LINKS_MAX} are supported: merge fixed ones")]
    TooManyLinks {
        /// Its number of links.
        links: usize,
    },
    /// The robot is not a biped.
    #[error("the robot has {feet} feet; the planner walks on exactly 2")]
    FeetCount {
        /// Its number of feet.
        feet: usize,
    },
}

/// The compiled robot. Constant during a search.
#[derive(Debug, Clone)]
pub struct Mechanism {
    /// Forward kinematics.
    pub tree: KinematicTree,
    /// Bounding spheres of the links with collision shapes.
    pub spheres: Vec<BodySphere>,
    /// Masses, and the efforts that may be used.
    pub mass_tree: MassTree,
    /// The legs, by limb.
    pub legs: [Leg; 2],
    /// The soles, by limb.
    pub soles: [Sole; 2],
    /// Joint positions of the standing posture.
    pub standing_q: [f64; JOINTS_MAX],
    /// Centre of mass of the standing posture in the root frame, m.
    pub standing_com: DVec3,
    /// The largest height of the centre of mass over a stance sole that is expected, with a
    /// reserve, m: a foot that tilts moves the centre of mass by as much times the tilt.
    pub centre_height: f64,
    /// Larger one of both legs' extensions in the standing posture, 0 to 1.
    pub standing_leg_extension: f64,
    /// The joints that carry no foot.
    pub free_joints: Vec<FreeJoint>,
    /// Those of them that carry the trunk, seen from the root.
    pub trunk_joints: Vec<FreeJoint>,
    /// Number of joints in use.
    pub joints_len: usize,
}

/// The most by which the centre of mass rises over its height in the standing posture, m.
const CENTRE_RISE_MAX: f64 = 0.1;
/// Factor of that height, for ground that the planner and the checker sample differently.
const TILT_RESERVE: f64 = 1.25;

impl Mechanism {
    /// Compiles a robot.
    ///
    /// # Errors
    /// The robot is not a biped, has more than [`LINKS_MAX`] links, or has a leg with too few or
    /// too many joints.
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
        let tree = KinematicTree::new(model);
        let mass_tree = MassTree::new(model, config.effort_share);
        let free_joints = free_joints(model, margin, &mass_tree);
        let ankle_limits =
            |leg: &Leg| AnkleLimits::new(leg, &standing_q, &mass_tree, config.com_margin);
        let standing_com = tree.total_moment(&standing_q) / mass_tree.mass();
        let heights =
            legs.each_ref().map(|leg| (leg.root_from_sole(&standing_q).inverse() * standing_com).z);
        let centre_height = TILT_RESERVE * (heights[0].max(heights[1]).max(0.0) + CENTRE_RISE_MAX);
        Ok(Self {
            spheres: body_spheres(model, &tree),
            soles: [
                Sole::new(model, left, ankle_limits(&legs[0])),
                Sole::new(model, right, ankle_limits(&legs[1])),
            ],
            standing_com,
            centre_height,
            standing_leg_extension: legs
                .iter()
                .map(|leg| leg.extension(&standing_q))
                .fold(0.0, f64::max),
            trunk_joints: trunk_joints(&free_joints, &mass_tree),
            free_joints,
            joints_len: model.joints.len(),
            tree,
            mass_tree,
            legs,
            standing_q,
        })
    }

    /// Whether configurations with this rotation of the root are projected: it leans far, and the
    /// legs have no closed form. Near the singularities of such legs inverse kinematics of one leg
    /// after the other finds hardly any.
    pub fn is_projected_at(&self, world_from_root: DQuat) -> bool {
        let up = world_from_root * DVec3::Z;
        up.z < PROJECTED_LEAN_COSINE && !self.legs.iter().all(Leg::is_closed_form)
    }

    /// Moves both legs so that the soles reach these poses. Returns `false` if a leg has no
    /// solution; the leg before it has moved then.
    pub fn place_soles(
        &self,
        configuration: &mut Configuration,
        world_from_soles: &[Pose; 2],
    ) -> bool {
        self.place_soles_by(configuration, world_from_soles, Leg::solve)
    }

    /// As [`Self::place_soles`], by [`Leg::solve_near`], which is cheaper where there is no
    /// solution: for samples.
    pub fn place_soles_near(
        &self,
        configuration: &mut Configuration,
        world_from_soles: &[Pose; 2],
    ) -> bool {
        self.place_soles_by(configuration, world_from_soles, Leg::solve_near)
    }

    fn place_soles_by(
        &self,
        configuration: &mut Configuration,
        world_from_soles: &[Pose; 2],
        solve: impl Fn(&Leg, &Pose, &mut [f64]) -> bool,
    ) -> bool {
        let root_from_world = configuration.world_from_root.inverse();
        self.legs
            .iter()
            .zip(world_from_soles)
            .all(|(leg, sole)| solve(leg, &(root_from_world * *sole), &mut configuration.q))
    }

    /// Whether all joints are at most `beyond` (rad or m) outside of the planner's limits.
    pub fn is_within_limits(&self, q: &[f64; JOINTS_MAX], beyond: f64) -> bool {
        let of_legs = self.legs.iter().flat_map(Leg::joints);
        let limits = of_legs.map(|joint| (joint.index, joint.lower, joint.upper));
        let of_others =
            self.free_joints.iter().map(|joint| (joint.index, joint.lower, joint.upper));
        limits
            .chain(of_others)
            .all(|(index, lower, upper)| (lower - beyond..=upper + beyond).contains(&q[index]))
    }

    /// Reach of the shorter leg, m.
    pub fn shorter_reach(&self) -> f64 {
        self.legs.iter().map(Leg::reach).fold(f64::INFINITY, f64::min)
    }

    /// The greatest height of the root (m) at which no leg exceeds its extension (0 to 1), for the
    /// horizontal position and the rotation of `root`; `None` if a foot is too far to the side.
    pub fn root_height(
        &self,
        root: &Pose,
        world_from_soles: &[Pose; 2],
        leg_extensions: [f64; 2],
    ) -> Option<f64> {
        let mut height = f64::INFINITY;
        for ((leg, sole), extension) in self.legs.iter().zip(world_from_soles).zip(leg_extensions) {
            let hip = root.rotation * leg.hip();
            let ankle = *sole * leg.sole_from_ankle();
            let lateral_squared = (ankle - root.translation - hip).truncate().length_squared();
            let length = extension * leg.reach();
            let rise_squared = length * length - lateral_squared;
            if rise_squared <= 0.0 {
                return None;
            }
            height = height.min(ankle.z + libm::sqrt(rise_squared) - hip.z);
        }
        Some(height)
    }
}
