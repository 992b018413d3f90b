//! The motion of an exported plan: the robot at any time, and the feet that carry it.

use std::path::Path;

use glam::DQuat;
use surefoot_shared_types::InputError;
use surefoot_shared_types::message::{Contact, Interpolation, SupportMode, Waypoint};
use surefoot_shared_types::plan_file::chunks;
use surefoot_shared_types::plan_file::origin::changed_files;
use surefoot_shared_types::plan_file::read::{joint_order, load_plan, robot_and_world};
use surefoot_shared_types::plan_format::blocks::{
    OriginBlock, PhaseBlock, PlanFile, WaypointBlock,
};
use surefoot_shared_types::robot::model::RobotModel;
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

impl SupportPhase {
    /// The contact of a foot, if it is a stance foot.
    pub fn contact(&self, limb: usize) -> Option<&Contact> {
        self.contacts.iter().find(|contact| contact.limb as usize == limb)
    }
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
        let (model, world) = robot_and_world(&plan, path)?;
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
    Waypoint { root_rotation: unit(block.root_quat_xyzw), ..chunks::waypoint(block, order) }
}

fn phase(model: &RobotModel, block: &PhaseBlock) -> SupportPhase {
    let contacts = model.feet.iter().filter_map(|foot| {
        let stated = block.contacts.iter().find(|contact| contact.foot == foot.name)?;
        let contact = chunks::contact(model, stated).ok()?;
        Some(Contact { rotation: unit(stated.sole_pose.quat_xyzw), ..contact })
    });
    SupportPhase {
        first: block.first,
        last: block.last,
        mode: SupportMode::from_name(&block.mode).unwrap_or(SupportMode::Double),
        contacts: contacts.collect(),
    }
}

/// The same rotation, of unit length to the last bit.
fn unit(quat_xyzw: [f64; 4]) -> [f64; 4] {
    DQuat::from_array(quat_xyzw).normalize().to_array()
}
