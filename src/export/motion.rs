//! The motion of an exported plan: the robot at any time, and the feet that carry it.

use std::path::Path;

use glam::DQuat;
use surefoot_shared_types::InputError;
use surefoot_shared_types::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};
use surefoot_shared_types::base::spatial::Pose;
use surefoot_shared_types::message::chunk::ROOT_FREEDOMS;
use surefoot_shared_types::message::{Contact, Interpolation, SupportMode, Waypoint};
use surefoot_shared_types::plan_file::origin::changed_files;
use surefoot_shared_types::plan_file::read::{joint_order, load_plan};
use surefoot_shared_types::plan_format::blocks::{
    OriginBlock, PhaseBlock, PlanFile, PoseBlock, WaypointBlock,
};
use surefoot_shared_types::robot::load::robot_from_block;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::world_from_block;
use surefoot_shared_types::world::world::World;

use crate::export::error::ExportError;

/// A plan with its robot and its world. Joints are in the model's order.
#[derive(Debug, Clone)]
pub struct ExportMotion {
    /// The robot; its root is the URDF's root link.
    pub model: RobotModel,
    /// The world.
    pub world: World,
    /// What the plan was made from, if it states it.
    pub origin: Option<OriginBlock>,
    /// The waypoints; at least one.
    pub waypoints: Vec<Waypoint>,
    /// How the robot moves between them.
    pub interpolation: Interpolation,
    /// Whether the waypoints state feed-forward efforts.
    pub has_torque: bool,
    /// The support phases, which cover all waypoints in order.
    pub phases: Vec<SupportPhase>,
}

/// A range of waypoints with one support mode.
#[derive(Debug, Clone)]
pub struct SupportPhase {
    /// Index of the first waypoint.
    pub first: usize,
    /// Index of the last waypoint, included.
    pub last: usize,
    /// The support mode.
    pub mode: SupportMode,
    /// The stance feet. Their polygons are the whole soles.
    pub contacts: Vec<Contact>,
}

impl ExportMotion {
    /// Loads a plan file with the robot and the world that it names.
    ///
    /// # Errors
    /// One of the files cannot be used, or has changed since the plan was made.
    pub fn load(path: &Path) -> Result<Self, ExportError> {
        let plan = load_plan(path)?;
        if let Some(changed) = changed_files(&plan, path).into_iter().next() {
            return Err(ExportError::Changed { changed });
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let model = robot_from_block(&plan.robot, folder, path)?;
        let world = world_from_block(&plan.scene, folder, path)?;
        Self::new(&plan, path, model, world)
    }

    /// The motion of a plan that was loaded from `path`, with its robot and world.
    ///
    /// # Errors
    /// The plan does not fit the robot, or has no waypoints.
    pub fn new(
        plan: &PlanFile,
        path: &Path,
        model: RobotModel,
        world: World,
    ) -> Result<Self, ExportError> {
        let order = joint_order(plan, &model, path)?;
        let Some(first) = plan.waypoints.first() else {
            return Err(InputError::file(path, "has no waypoints: nothing to export").into());
        };
        let phases = plan.phases.iter().map(|block| phase(&model, block));
        Ok(Self {
            waypoints: plan.waypoints.iter().map(|block| waypoint(block, &order)).collect(),
            interpolation: if first.velocity.is_empty() {
                Interpolation::Linear
            } else {
                Interpolation::Quintic
            },
            has_torque: !first.torque.is_empty(),
            phases: phases.collect(),
            origin: plan.origin.clone(),
            model,
            world,
        })
    }

    /// The time of the first and of the last waypoint, s.
    pub fn span(&self) -> (f64, f64) {
        (self.waypoints[0].time, self.waypoints[self.waypoints.len() - 1].time)
    }

    /// The robot at a time (s), which is clamped to the plan's. At a waypoint of a plan of straight
    /// lines the velocity is that of the interval after it.
    pub fn sample(&self, time: f64) -> Waypoint {
        self.interpolation.sample(&self.waypoints, time)
    }

    /// The index of the phase at a time (s): the later one where two meet.
    pub fn phase_at(&self, time: f64) -> usize {
        let begins_before = |phase: &SupportPhase| self.waypoints[phase.first].time <= time;
        self.phases.partition_point(begins_before).saturating_sub(1)
    }

    /// The begin and the end of a phase, s.
    pub fn phase_span(&self, phase: &SupportPhase) -> (f64, f64) {
        (self.waypoints[phase.first].time, self.waypoints[phase.last].time)
    }
}

fn waypoint(block: &WaypointBlock, order: &[usize]) -> Waypoint {
    let sorted = |numbers: &[f64]| {
        let mut sorted = [0.0; JOINTS_MAX];
        for (slot, &place) in sorted.iter_mut().zip(order) {
            *slot = numbers.get(place).copied().unwrap_or(0.0);
        }
        sorted
    };
    let split = |numbers: &[f64]| {
        let mut root = [0.0; ROOT_FREEDOMS];
        root.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = *number);
        (root, sorted(numbers.get(ROOT_FREEDOMS..).unwrap_or(&[])))
    };
    let rotation = DQuat::from_array(block.root_quat_xyzw).normalize();
    let root = Pose::from_parts(block.root_xyz.into(), rotation);
    let mut waypoint = Waypoint::at_rest(block.t, &root, &sorted(&block.q));
    (waypoint.root_velocity, waypoint.joint_velocity) = split(&block.velocity);
    (waypoint.root_acceleration, waypoint.joint_acceleration) = split(&block.acceleration);
    waypoint.torque = sorted(&block.torque);
    waypoint
}

fn phase(model: &RobotModel, block: &PhaseBlock) -> SupportPhase {
    let modes = [SupportMode::Left, SupportMode::Right, SupportMode::Double];
    let mode = modes.into_iter().find(|mode| mode.name() == block.mode);
    let contacts = model.feet.iter().enumerate().filter_map(|(limb, foot)| {
        let stated = block.contacts.iter().find(|contact| contact.foot == foot.name)?;
        let mut contact = contact(limb, &stated.sole_pose);
        contact.polygon_len = foot.polygon.len().min(POLYGON_VERTICES_MAX) as u32;
        let corners = contact.polygon.iter_mut().zip(&foot.polygon);
        corners.for_each(|(slot, corner)| *slot = corner.to_array());
        Some(contact)
    });
    SupportPhase {
        first: block.first,
        last: block.last,
        mode: mode.unwrap_or(SupportMode::Double),
        contacts: contacts.collect(),
    }
}

fn contact(limb: usize, pose: &PoseBlock) -> Contact {
    Contact {
        limb: limb as u32,
        position: pose.xyz,
        rotation: DQuat::from_array(pose.quat_xyzw).normalize().to_array(),
        ..bytemuck::Zeroable::zeroed()
    }
}
