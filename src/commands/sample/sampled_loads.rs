//! The loads of a set-point: contact wrenches, and joint torques where the plan states none.

use std::path::Path;

use glam::DVec3;
use surefoot_controller_sim::Checker;
use surefoot_controller_sim::check::checker::SoleSupports;
use surefoot_shared_types::message::set_point::FLAG_LOADS;
use surefoot_shared_types::message::{Description, PlanChunk, SetPoint};

use crate::export::loads::moment_about;
use crate::input::inputs::{Inputs, Overrides};
use crate::report::command_error::CommandError;

/// A chunk's plan, epoch and sequence number.
type ChunkKey = (u64, u64, u64);

/// Computes the contact forces of least squares with which the robot moves as a set-point says.
pub(crate) struct SampledLoads {
    checker: Checker,
    /// The soles' supports in the chunk that was loaded last.
    supports: Option<(ChunkKey, SoleSupports)>,
}

impl SampledLoads {
    /// The loads of a scenario's robot in its world.
    ///
    /// # Errors
    /// The scenario, its robot or its world cannot be used.
    pub(crate) fn load(scenario: &Path) -> Result<Self, CommandError> {
        let Inputs { scenario, model, world, .. } = Inputs::load(scenario, Overrides::default())?;
        let checker = Checker::new(model, world, scenario.checker)?;
        Ok(Self { checker, supports: None })
    }

    /// Refuses the description of another robot.
    ///
    /// # Errors
    /// It is another robot.
    pub(crate) fn check(&self, description: &Description) -> Result<(), CommandError> {
        if description.robot == self.checker.model().digest {
            return Ok(());
        }
        let message = "--loads: the scenario's robot is not the one of the instance; name the scenario that it walks";
        Err(CommandError::Usage(message.to_owned()))
    }

    /// Adds the loads to a set-point in `chunk`; none where no forces hold the robot.
    pub(crate) fn add(&mut self, chunk: &PlanChunk, point: &mut SetPoint) {
        let key = (chunk.plan_id, chunk.epoch, chunk.sequence);
        let supports = match self.supports.take() {
            Some((known, supports)) if known == key => supports,
            _ => self.checker.sole_supports(chunk.contacts(), chunk.waypoints()),
        };
        let load = self.checker.moving_load(&supports, &point.waypoint);
        self.supports = Some((key, supports));
        if load.feet.is_empty() {
            return;
        }
        point.flags |= FLAG_LOADS;
        for foot in &load.feet {
            let schedule = &mut point.feet[foot.limb];
            let sole = DVec3::from_array(schedule.position);
            schedule.force = foot.force.to_array();
            schedule.moment = moment_about(foot, sole).to_array();
        }
        let torque = &mut point.waypoint.torque;
        if torque.iter().all(|torque| *torque == 0.0) {
            let joints = self.checker.model().joints.len();
            torque[..joints].copy_from_slice(&load.torques[..joints]);
        }
    }
}
