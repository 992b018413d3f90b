//! Contact wrenches and joint efforts of a robot that stands still in each configuration of a plan.

use glam::DVec3;
use surefoot_controller_sim::check::checker::SoleSupports;
use surefoot_controller_sim::kinematics::forward::Configuration;
use surefoot_controller_sim::statics::{ContactLoad, FootLoad};
use surefoot_controller_sim::{Checker, CheckerError};
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Waypoint;

use crate::export::error::ExportError;
use crate::export::motion::ExportMotion;

/// The moment (N m) of the ground on a foot about a point in the world.
pub fn moment_about(foot: &FootLoad, point: DVec3) -> DVec3 {
    foot.moment + (foot.centre - point).cross(foot.force)
}

/// Computes static loads: the contact forces of least squares within the friction, which carry the
/// robot's weight, and the joint efforts under them. Motion adds nothing to them.
pub struct StaticLoads {
    checker: Checker,
    /// The support of the stance feet, by phase.
    supports: Vec<SoleSupports>,
}

impl StaticLoads {
    /// The loads of a plan.
    ///
    /// # Errors
    /// The robot or the world has shapes that contacts cannot be computed with.
    pub fn new(motion: &ExportMotion) -> Result<Self, CheckerError> {
        let config = CheckerConfig::default();
        let mut checker = Checker::new(motion.model.clone(), motion.world.clone(), config)?;
        let supports = motion.phases.iter().map(|phase| {
            checker.sole_supports(&phase.contacts, &motion.waypoints[phase.first..=phase.last])
        });
        let supports = supports.collect();
        Ok(Self { checker, supports })
    }

    /// The load at a waypoint in a phase.
    ///
    /// # Errors
    /// No contact forces hold the robot there.
    pub fn at(&mut self, waypoint: &Waypoint, phase: usize) -> Result<ContactLoad, ExportError> {
        let joints = self.checker.model().joints.len();
        let configuration = Configuration::of_waypoint(waypoint, joints);
        let load = self.checker.load(&self.supports[phase], &configuration);
        if load.feet.is_empty() {
            return Err(ExportError::NoEquilibrium { time: waypoint.time });
        }
        Ok(load)
    }
}
