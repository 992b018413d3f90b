//! The controller's checks, written apart from the planner.

use std::path::Path;

use surefoot_controller_sim::check::checker::Checker as SegmentChecker;
use surefoot_controller_sim::{Course, MotionSegment, PlanReport, Stop, Violation, check_plan};
pub use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::{Check, SupportMode};
use surefoot_shared_types::plan_file::read::load_plan;

use crate::api::error::CheckError;
use crate::api::parameters::Parameters;
use crate::api::plan::{Plan, PlanChunk};
use crate::api::robot::Robot;
use crate::api::world::World;

/// Checks motions of one robot in one world: balance, contact, collision, limits and torque, with
/// code that shares no algorithm with the planner. `docs/CHECKER.md` says what each check demands.
pub struct Checker {
    checker: SegmentChecker,
}

impl Checker {
    /// Prepares all that does not depend on the motion. The tolerances are `parameters.checker`.
    ///
    /// # Errors
    /// The robot is not a biped, or the checker cannot compute with a shape of the robot or the
    /// world.
    pub fn new(robot: &Robot, world: &World, parameters: &Parameters) -> Result<Self, CheckError> {
        let (model, world) = (robot.model().clone(), world.model().clone());
        Ok(Self { checker: SegmentChecker::new(model, world, parameters.checker.clone())? })
    }

    /// Checks the motion of a chunk of any origin, and returns its worst margins.
    ///
    /// # Errors
    /// The first violation: which check, at which waypoint, by how much.
    pub fn check(&mut self, chunk: &PlanChunk) -> Result<Margins, Violation> {
        let Some(mode) = SupportMode::from_wire(chunk.mode) else {
            return Err(Violation::new(
                Check::Malformed,
                0,
                format!("mode {} is unknown", chunk.mode),
            ));
        };
        let (contacts, waypoints) = (chunk.contacts(), chunk.waypoints());
        let stop = [Stop::of_chunk(chunk)];
        let course = if Stop::is_smooth(chunk) { Course::Smooth(&stop) } else { Course::Straight };
        self.checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || ())
    }

    /// Checks all chunks of a plan, and returns the worst margins.
    ///
    /// # Errors
    /// The first violation, and the chunk that it is in.
    pub fn check_plan(&mut self, plan: &Plan) -> Result<Margins, (usize, Violation)> {
        let mut margins = Margins::UNMEASURED;
        for (index, chunk) in plan.chunks().iter().enumerate() {
            margins = margins.min(&self.check(chunk).map_err(|violation| (index, violation))?);
        }
        Ok(margins)
    }

    /// Checks an exported plan file (`biped-plan/1`), which names its robot and its world.
    ///
    /// # Errors
    /// The file, its robot or its world cannot be used. Violations are part of the report.
    pub fn check_file(path: impl AsRef<Path>) -> Result<PlanReport, CheckError> {
        let plan = load_plan(path.as_ref())?;
        Ok(check_plan(&plan, path.as_ref())?)
    }
}
