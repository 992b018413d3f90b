//! The controller's checks, written apart from the planner.

use std::path::Path;

use surefoot_controller_sim::check::checker::Checker as SegmentChecker;
use surefoot_controller_sim::{
    Course, MotionSegment, PlanReport, Problem, Stop, Violation, check_content, check_plan,
    check_plan_in,
};
pub use surefoot_shared_types::message::Margins;
use surefoot_shared_types::plan_file::read::load_plan;

use crate::api::error::{AnswerError, CheckError};
use crate::api::parameters::Parameters;
use crate::api::plan::{Plan, PlanChunk};
use crate::api::robot::Robot;
use crate::api::stance::{Goal, Stance, content};
use crate::api::world::World;

/// The name of a plan in memory in errors.
const IN_MEMORY: &str = "plan";

/// Checks motions of one robot in one world: balance, contact, collision, limits and torque, with
/// code that shares no algorithm with the planner. `docs/CHECKER.md` says what each check demands.
pub struct Checker {
    checker: SegmentChecker,
    robot: Robot,
    world: World,
    parameters: Parameters,
}

impl Checker {
    /// Prepares all that does not depend on the motion. The tolerances are `parameters.checker`.
    ///
    /// # Errors
    /// The robot is not a biped, or the checker cannot compute with a shape of the robot or the
    /// world.
    pub fn new(robot: &Robot, world: &World, parameters: &Parameters) -> Result<Self, CheckError> {
        let (robot, world, parameters) = (robot.clone(), world.clone(), parameters.clone());
        let config = parameters.checker.clone();
        let checker = SegmentChecker::new(robot.model().clone(), world.model().clone(), config)?;
        Ok(Self { checker, robot, world, parameters })
    }

    /// The checker of single motions.
    pub(crate) fn segment_checker(&mut self) -> &mut SegmentChecker {
        &mut self.checker
    }

    /// Checks the motion of a chunk of any origin, and returns its worst margins. Of its stop, the
    /// part within the chunk is checked.
    ///
    /// # Errors
    /// The first violation: which check, at which waypoint, by how much.
    pub fn check(&mut self, chunk: &PlanChunk) -> Result<Margins, Violation> {
        let mode = check_content(chunk, self.robot.model().joints.len())?;
        let (contacts, waypoints) = (chunk.contacts(), chunk.waypoints());
        let stop = [Stop::of_chunk(chunk)];
        let course = if chunk.is_smooth() { Course::Smooth(&stop) } else { Course::Straight };
        self.checker.check_segment(&MotionSegment { mode, contacts, waypoints, course }, &mut || ())
    }

    /// Checks all chunks of a plan, each by itself, and returns the worst margins.
    /// [`Checker::answer`] checks that they continue each other, and all of their stops.
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

    /// Checks a whole plan as a walk from `start` to `goal`: every motion, their continuity, where
    /// it begins and where it ends. Violations are part of the report.
    ///
    /// # Errors
    /// A number of the start, the goal or the parameters is out of range, or the plan moves other
    /// joints than the robot has.
    pub fn answer(
        &self,
        plan: &Plan,
        start: Stance,
        goal: Goal,
    ) -> Result<PlanReport, AnswerError> {
        let scenario = content(&self.robot, start, goal, &self.parameters, 1).build()?;
        let (model, world) = (self.robot.model().clone(), self.world.model().clone());
        let file = plan.unsaved();
        let problem = Problem::of_stances(model, world, &scenario, &file);
        Ok(check_plan_in(&file, Path::new(IN_MEMORY), &problem)?)
    }

    /// As [`Checker::answer`], from the start to the goal that the plan states itself.
    ///
    /// # Errors
    /// The plan moves other joints than the robot has.
    pub fn answer_as_stated(&self, plan: &Plan) -> Result<PlanReport, AnswerError> {
        let (model, world) = (self.robot.model().clone(), self.world.model().clone());
        let file = plan.unsaved();
        let ends = [file.start.clone(), file.goal.clone()];
        let problem = Problem::of_ends(model, world, self.parameters.checker.clone(), ends);
        Ok(check_plan_in(&file, Path::new(IN_MEMORY), &problem)?)
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
